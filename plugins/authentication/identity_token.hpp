// IdentityToken: what discovery announces about an identity (DDS-Security 9.3.2.1).
#pragma once

#include "pki/certificate.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::authentication {

/// With all four properties, in the words that Cyclone DDS uses (DDS-Security 1.1).
spi::Token write_identity_token(const pki::Certificate& certificate, const pki::Certificate& ca);

/// What a peer claims about itself; nothing of it is proven, so nothing is decided by it.
struct IdentityClaim {
  std::string subject;  ///< dds.cert.sn, empty if absent
};

/// Errors: token_class_wrong, token_too_large.
Result<IdentityClaim> read_identity_token(const spi::Token& token);

}  // namespace ddssec::authentication
