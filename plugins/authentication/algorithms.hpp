// The algorithm names that go into the handshake, and what they mean (DDS-Security 9.3.4.1).
#pragma once

#include <optional>
#include <string_view>

#include "base/bytes.hpp"
#include "pki/certificate.hpp"
#include "pki/key_agreement.hpp"

namespace ddssec::authentication {

/// The text of an algorithm field without the one trailing NUL that Cyclone DDS counts in. For
/// comparison only: hashes and signatures cover the octets as received.
std::string_view algorithm_text(BytesView octets);

/// What we announce as c.dsign_algo for a key of our own: the 1.1 name where there is one, since
/// the stock peers refuse the 1.2 names.
std::string_view signature_algorithm_name(pki::KeyAlgorithm key);

/// True for the names of DDS-Security 1.1 and 1.2. Which algorithm verifies is decided by the key
/// in c.id: Fast DDS announces the algorithm of its CA.
bool is_signature_algorithm(std::string_view name);

/// What we announce as c.kagree_algo when we begin.
std::string_view key_agreement_name(pki::KeyAgreementKind kind);

/// From a 1.1 or 1.2 name.
std::optional<pki::KeyAgreementKind> key_agreement_kind_from(std::string_view name);

}  // namespace ddssec::authentication
