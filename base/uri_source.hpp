// The source of a key, certificate, document or passphrase: the URI in a property
// (DDS-Security 1.2, clause 10.3.1).
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "base/bytes.hpp"
#include "base/hash.hpp"
#include "base/result.hpp"

namespace ddssec {

/// Returns the octets that `uri` names: `file:PATH`, `file://PATH` or `data:,TEXT`, with any number
/// of leading blanks. TEXT is taken literally (no percent decoding), as peers do. Errors name
/// `property` as their document. No copy of the octets remains besides the result. Errors:
/// missing_property (empty URI), unsupported_uri, pkcs11_unsupported, file_not_found,
/// file_unreadable, file_too_large (more than `max_octets` octets), item_empty.
Result<Bytes> load_uri(std::string_view uri, std::string_view property, std::size_t max_octets);

/// As load_uri, for secret octets, which the caller must wipe. No error repeats a part of `uri`
/// that may be a secret.
Result<Bytes> load_secret_octets(std::string_view uri, std::string_view property,
                                 std::size_t max_octets);

/// Loads the octets into a Secret, at most as many as it holds. No copy stays in memory.
template <class S>
Result<S> load_secret(std::string_view uri, std::string_view property) {
  auto octets = load_secret_octets(uri, property, S::capacity);
  if (!octets) return std::unexpected(std::move(octets).error());
  auto secret = S::copy_of(*octets);
  wipe(*octets);
  return secret;
}

/// Returns the error about a document that has too many octets: `max_octets` are accepted.
Error too_many_octets_error(Code code, std::size_t max_octets, std::size_t found);

/// True if `uri` names an object of a PKCS#11 token (RFC 7512), which pki reads.
bool names_token(std::string_view uri);

/// Returns the part of a PKCS#11 URI that may be shown, at most 256 characters: the attributes of
/// RFC 7512 that tell where the object is. All others are left out, because a misspelt one may hold
/// a PIN. Empty if `uri` is no PKCS#11 URI.
std::string without_pin(std::string_view uri);

/// Returns the path that `uri` names; empty if it names no file.
std::optional<std::string> file_named_by(std::string_view uri);

/// Returns `uri` with an absolute path if it names a file by a relative one, so that it names the
/// same file after the process has changed its working directory. Returns any other URI unchanged.
/// If there is no working directory, the result is empty, and no file can be read by it.
std::string absolute_uri(std::string_view uri);

/// True if `uri` names a file that its group or others may read.
bool readable_by_others(std::string_view uri);

}  // namespace ddssec
