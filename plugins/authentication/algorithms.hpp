// The algorithm names in handshake messages and their meaning (DDS-Security 1.2, clause 10.3.2.5).
#pragma once

#include <optional>
#include <string_view>

#include "base/bytes.hpp"
#include "pki/certificate.hpp"
#include "pki/key_agreement.hpp"

namespace ddssec::authentication {

/// Returns the text of an algorithm field without the one trailing NUL that Cyclone DDS includes in
/// the length. For comparison only: hashes and signatures cover the octets as received.
std::string_view algorithm_text(BytesView octets);

/// Returns the c.dsign_algo to send for a local key: the name from DDS-Security 1.1 where there is
/// one, because stock peers refuse the names of 1.2.
std::string_view signature_algorithm_name(pki::KeyAlgorithm key);

/// True for the names of DDS-Security 1.1 and 1.2. The name does not select the algorithm: the key
/// in c.id does, because Fast DDS announces the algorithm of its CA.
bool is_signature_algorithm(std::string_view name);

/// Returns the c.kagree_algo to send as initiator.
std::string_view key_agreement_name(pki::KeyAgreementKind kind);

/// Returns the kind of a name of DDS-Security 1.1 or 1.2; empty for any other name.
std::optional<pki::KeyAgreementKind> key_agreement_kind_from(std::string_view name);

}  // namespace ddssec::authentication
