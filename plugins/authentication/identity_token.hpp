// IdentityToken: the announcement of an identity in discovery (DDS-Security 1.2, clause 10.3.2.1).
#pragma once

#include "pki/certificate.hpp"
#include "plugins/spi/symmetric_cipher.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::authentication {

/// Returns the token with all four properties, in the spelling that Cyclone DDS uses (DDS-Security
/// 1.1). A fifth, private property lists the ciphers if there are more than the standard ones.
spi::Token write_identity_token(const pki::Certificate& certificate, const pki::Certificate& ca,
                                spi::CipherMask ciphers);

/// Returns the ciphers that a token announces; always includes the standard ones.
spi::CipherMask announced_ciphers(const spi::Token& identity_token);

/// An unproven claim of a peer. No decision depends on it.
struct IdentityClaim {
  std::string subject;  ///< dds.cert.sn, empty if absent
};

/// Reads a peer's token. Errors: token_class_wrong, token_too_large.
Result<IdentityClaim> read_identity_token(const spi::Token& token);

}  // namespace ddssec::authentication
