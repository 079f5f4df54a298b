// The key revision that a protected message or submessage names.
#pragma once

#include "base/bytes.hpp"
#include "plugins/spi/cryptography.hpp"

namespace ddssec::spi {

/// Returns the first three octets of transformation_kind (DDS-Security 1.2, clause 7.3.17).
/// `protected_part` begins with SEC_PREFIX or SRTPS_PREFIX; 0 if it is too short. The key of that
/// revision alone opens it, so after it was opened the revision is proven.
constexpr KeyRevision named_key_revision(BytesView protected_part) {
  constexpr std::size_t kKindAt = 4;
  if (protected_part.size() < kKindAt + 3) return 0;
  const auto* octets = protected_part.data() + kKindAt;
  return KeyRevision{octets[0]} << 16 | KeyRevision{octets[1]} << 8 | octets[2];
}

}  // namespace ddssec::spi
