// Where a key, certificate, document or passphrase comes from: the URI in a property (DDS-Security
// 9.3.1).
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "base/bytes.hpp"
#include "base/hash.hpp"
#include "base/result.hpp"

namespace ddssec {

/// The octets that `uri` names: `file:PATH`, `file://PATH` or `data:,TEXT`, with any number of
/// leading blanks. TEXT is taken as it stands (no percent decoding), as peers do.
/// `property` is what an error names as its document. What was read is in the result alone.
/// Errors: missing_property (empty URI), unsupported_uri, pkcs11_unsupported, file_not_found,
/// file_unreadable, file_too_large (more than `most` octets), item_empty.
Result<Bytes> load(std::string_view uri, std::string_view property, std::size_t most);

/// The same for octets that the caller wipes: no error repeats any of `uri` that may be a secret.
Result<Bytes> load_secret_octets(std::string_view uri, std::string_view property, std::size_t most);

/// The same into a Secret, as much as it holds; nothing of it stays behind in memory.
template <class S>
Result<S> load_secret(std::string_view uri, std::string_view property) {
  auto octets = load_secret_octets(uri, property, S::capacity);
  if (!octets) return std::unexpected(std::move(octets).error());
  auto secret = S::copy_of(*octets);
  wipe(*octets);
  return secret;
}

/// True if `uri` names what a PKCS#11 token holds (RFC 7512); pki reads those.
bool names_token(std::string_view uri);

/// Of such a URI what may be shown: without its query and whatever may be a PIN.
std::string without_pin(std::string_view uri);

/// The path that `uri` names; nothing if it names no file.
std::optional<std::string> file_named_by(std::string_view uri);

/// True if `uri` names a file whose mode lets its group or everybody read it.
bool readable_by_others(std::string_view uri);

}  // namespace ddssec
