// Limits for keys, certificates and documents that a URI names, and functions that read them
// (base/uri_source.hpp).
#pragma once

#include <cstddef>
#include <filesystem>
#include <string_view>

#include "base/secret.hpp"
#include "base/uri_source.hpp"

namespace ddssec::pki {

/// The longest identity certificate that is read, in octets.
inline constexpr std::size_t kMaxCertificateOctets = 64 * 1024;
/// The longest file of certificates, in octets.
inline constexpr std::size_t kMaxBundleOctets = 1024 * 1024;
/// The longest governance document, permissions document or revocation list, in octets.
inline constexpr std::size_t kMaxDocumentOctets = 16 * 1024 * 1024;
/// The longest signed permissions document, in octets, that ddssec's plugins send or accept from a
/// peer.
inline constexpr std::size_t kMaxSentPermissionsOctets = 1024 * 1024;

/// The PEM text of a private key, which may be as long as that of RSA-16384.
using KeyPem = Secret<struct KeyPemTag, 16 * 1024>;

using ddssec::load_uri;

/// Loads certificates in PEM by their URI: like load_uri(), and for `pkcs11:` (RFC 7512) the
/// certificate in a token. Errors: those of load_uri(); pkcs11_unavailable, pkcs11_not_found,
/// internal.
Result<Bytes> load_certificates(std::string_view uri, std::string_view property,
                                std::size_t max_octets);

/// Returns the URI of the key or certificate at `path`: that of the file, or, if its name is *.p11
/// as in keystores of ROS 2, the `pkcs11:` URI in it. Errors: those of load_uri(); unsupported_uri.
Result<std::string> uri_of(const std::filesystem::path& path);

/// Turns an error of load_uri() or of the parser into one about the file, with the path as its
/// document.
Error file_error(const Error& error, const std::filesystem::path& path);

}  // namespace ddssec::pki
