// How long keys, certificates and documents may be that a URI names (base/source.hpp reads them).
#pragma once

#include <cstddef>
#include <filesystem>
#include <string_view>

#include "base/secret.hpp"
#include "base/source.hpp"

namespace ddssec::pki {

/// The longest identity certificate that is read, in octets.
inline constexpr std::size_t kMostCertificateOctets = 64 * 1024;
/// The longest file of certificates, in octets.
inline constexpr std::size_t kMostBundleOctets = 1024 * 1024;
/// The longest governance document, permissions document or revocation list, in octets.
inline constexpr std::size_t kMostDocumentOctets = 16 * 1024 * 1024;

/// The PEM text of a private key: up to RSA-16384.
using KeyPem = Secret<struct KeyPemTag, 16 * 1024>;

using ddssec::load;

/// A private key, by its URI; nothing of it stays behind in memory. Errors: those of load().
Result<KeyPem> load_key(std::string_view uri, std::string_view property);

/// An error of load() or of what was loaded, as one about the file: the path is its document, and
/// not what was found.
Error about_file(const Error& error, const std::filesystem::path& path);

}  // namespace ddssec::pki
