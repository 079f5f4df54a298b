// IdentityToken: what discovery announces about an identity (DDS-Security 9.3.2.1).
#pragma once

#include "pki/certificate.hpp"
#include "plugins/spi/symmetric_cipher.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::authentication {

/// With all four properties, in the words that Cyclone DDS uses (DDS-Security 1.1), and a fifth of
/// our own where there is more than the standard's ciphers to announce.
spi::Token write_identity_token(const pki::Certificate& certificate, const pki::Certificate& ca,
                                spi::CipherMask ciphers);

/// The ciphers that a token announces; the standard's always.
spi::CipherMask announced_ciphers(const spi::Token& identity_token);

/// What a peer claims about itself; nothing of it is proven, so nothing is decided by it.
struct IdentityClaim {
  std::string subject;  ///< dds.cert.sn, empty if absent
};

/// Errors: token_class_wrong, token_too_large.
Result<IdentityClaim> read_identity_token(const spi::Token& token);

}  // namespace ddssec::authentication
