// <allowed_crypto_algorithms> of a governance document (DDS-Security 1.2 10.4.1.2.5.9) held against
// what a participant has and what a handshake used.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "governance/model.hpp"
#include "pki/certificate.hpp"

namespace ddssec::access_control {

/// <digital_signature> and the list for trust chains: the key of an identity certificate and those
/// of the CAs among `authorities` that vouch for it, one above the other. A list allows a key by
/// the names of the algorithms that sign with it; it says nothing of the padding of RSA, which a
/// CA chose years ago. Errors: identity_algorithm_not_allowed, trust_chain_algorithm_not_allowed.
Status check_identity(const governance::AllowedAlgorithms& allowed,
                      const pki::Certificate& certificate,
                      std::span<const pki::Certificate> authorities);

/// The list for trust chains: who signs documents. Error: trust_chain_algorithm_not_allowed.
Status check_authority(const governance::AllowedAlgorithms& allowed,
                       const pki::Certificate& authority);

/// <key_establishment>: the c.kagree_algo of a handshake. Without it an authentication plugin that
/// does not say could have used any that DDS-Security 1.1 has: all of those have to be listed then.
/// Error: key_establishment_not_allowed.
Status check_key_establishment(const governance::AllowedAlgorithms& allowed,
                               std::optional<std::string_view> used);

}  // namespace ddssec::access_control
