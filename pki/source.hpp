// Where a key, certificate or document comes from: the URI in a property (DDS-Security 9.3.1).
#pragma once

#include <cstddef>
#include <filesystem>
#include <string_view>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "base/secret.hpp"

namespace ddssec::pki {

/// The longest identity certificate that is read, in octets.
inline constexpr std::size_t kMostCertificateOctets = 64 * 1024;
/// The longest file of certificates, in octets.
inline constexpr std::size_t kMostBundleOctets = 1024 * 1024;
/// The longest governance document, permissions document or revocation list, in octets.
inline constexpr std::size_t kMostDocumentOctets = 16 * 1024 * 1024;

/// The PEM text of a private key: up to RSA-16384.
using KeyPem = Secret<struct KeyPemTag, 16 * 1024>;

/// The octets that `uri` names: `file:PATH`, `file://PATH` or `data:,TEXT`, with any number of
/// leading blanks. TEXT is taken as it stands (no percent decoding), as peers do.
/// `property` is what an error names as its document.
/// Errors: missing_property (empty URI), unsupported_uri, pkcs11_unsupported, file_not_found,
/// file_unreadable, file_too_large (more than `most` octets), item_empty.
Result<Bytes> load(std::string_view uri, std::string_view property, std::size_t most);

/// The same for a private key; nothing of it stays behind in memory.
Result<KeyPem> load_key(std::string_view uri, std::string_view property);

/// An error of load() or of what was loaded, as one about the file: the path is its document, and
/// not what was found.
Error about_file(const Error& error, const std::filesystem::path& path);

}  // namespace ddssec::pki
