// Limits of time and volume for the keys of a participant.
#pragma once

#include <chrono>
#include <cstdint>

#include "plugins/spi/token.hpp"

namespace ddssec::spi {

/// The shortest lifetime: a shorter one would leave no time to revise keys before it ends.
inline constexpr std::chrono::seconds kMinKeyLifetime{20};
inline constexpr std::chrono::seconds kMaxKeyLifetime{std::chrono::hours(24 * 365)};

/// The limits. In both fields, 0 means no limit.
struct KeyLimits {
  std::chrono::seconds lifetime{0};
  std::uint64_t blocks = 0;  ///< blocks of 16 octets protected with one key

  bool any() const { return lifetime.count() != 0 || blocks != 0; }
};

/// Returns the values of `org.ddssec.crypto.key_lifetime` (seconds, kMinKeyLifetime to
/// kMaxKeyLifetime) and `org.ddssec.crypto.max_blocks_per_key`. A missing property is no limit.
/// Limits need a governance that enables key revision; this function does not check that. Error:
/// invalid_property.
Result<KeyLimits> key_limits(const PropertyList& properties);

}  // namespace ddssec::spi
