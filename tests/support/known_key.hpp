// Key pairs with a known private number, for tests with known answers.
#pragma once

#include "pki/key_agreement.hpp"

namespace ddssec::pki {

/// Makes key pairs from known private numbers. A friend of the classes of key_agreement.hpp.
struct KnownKey {
  /// Makes the pair of a given private number (big endian). Error: public_key_not_in_group if it is
  /// zero or too large.
  static Result<EphemeralKey> from_private(KeyAgreementKind kind, BytesView number);
};

}  // namespace ddssec::pki
