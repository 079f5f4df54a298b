// How long and for how much a participant lets its keys be used.
#pragma once

#include <chrono>
#include <cstdint>

#include "plugins/spi/token.hpp"

namespace ddssec::spi {

/// A shorter life than this leaves no time to revise keys before its end.
inline constexpr std::chrono::seconds kShortestKeyLifetime{20};
inline constexpr std::chrono::seconds kLongestKeyLifetime{std::chrono::hours(24 * 365)};

/// 0: no limit.
struct KeyLimits {
  std::chrono::seconds lifetime{0};
  std::uint64_t blocks = 0;  ///< of 16 octets, under any one key

  bool any() const { return lifetime.count() != 0 || blocks != 0; }
};

/// What `org.ddssec.crypto.key_lifetime` (seconds) and `org.ddssec.crypto.max_blocks_per_key` say.
/// They need a governance that enables key revision. Error: invalid_property.
Result<KeyLimits> key_limits(const PropertyList& properties);

}  // namespace ddssec::spi
