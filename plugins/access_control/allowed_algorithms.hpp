// Checks of certificates and handshakes against <allowed_crypto_algorithms> of a governance
// document (DDS-Security 1.2, clause 10.4.1.2.5.9).
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "governance/model.hpp"
#include "pki/certificate.hpp"

namespace ddssec::access_control {

/// Checks the key of an identity certificate against <digital_signature>, and the keys of the CAs
/// above it in `authorities` against the list for trust chains. A list allows a key by the names of
/// the algorithms that sign with it. The padding of RSA does not matter, because the CA chose it
/// years ago. Errors: identity_algorithm_not_allowed, trust_chain_algorithm_not_allowed (also if
/// the issuer is not in `authorities`).
Status check_identity(const governance::AllowedAlgorithms& allowed,
                      const pki::Certificate& certificate,
                      std::span<const pki::Certificate> authorities);

/// Checks the key of a CA that signs documents against the list for trust chains. Error:
/// trust_chain_algorithm_not_allowed.
Status check_authority(const governance::AllowedAlgorithms& allowed,
                       const pki::Certificate& authority);

/// Checks the c.kagree_algo of a handshake against <key_establishment>. `used` is empty if the
/// authentication plugin does not report it. It could then be any algorithm of DDS-Security 1.1, so
/// all of those must be listed. Error: key_establishment_not_allowed.
Status check_key_establishment(const governance::AllowedAlgorithms& allowed,
                               std::optional<std::string_view> used);

}  // namespace ddssec::access_control
