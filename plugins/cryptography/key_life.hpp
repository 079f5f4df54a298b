// The lifetime of a local participant's keys: the limits, and where within them the present keys
// end. Time and use are checked once a second, so that messages have no extra cost.
#pragma once

#include "plugins/spi/key_limits.hpp"

namespace ddssec::cryptography {

/// When the present keys of one local participant end. Not thread-safe.
class KeyLife {
 public:
  /// How often a host calls is_key_revision_due.
  static constexpr std::chrono::seconds kAsked{1};

  KeyLife() = default;
  explicit KeyLife(spi::KeyLimits limits) : limits_(limits) {}

  bool is_limited() const { return limits_.any(); }
  /// Notes that keys were made at `now`. They end at a random point in the last quarter of the
  /// limits, chosen by the random number `chance`. So participants that start together do not
  /// revise their keys together.
  void begin(std::chrono::nanoseconds now, std::uint64_t chance);
  bool has_ended(std::chrono::nanoseconds now) const;
  /// True if it is time to check the volume. New keys are not checked before they are older than
  /// former keys may be, so that few revisions are valid at a time, however low the limit is.
  bool counts_blocks(std::chrono::nanoseconds now) const;
  bool is_used_up(std::uint64_t blocks) const { return blocks >= last_block_; }

 private:
  spi::KeyLimits limits_;
  std::chrono::nanoseconds earliest_{0}, end_{0};
  std::uint64_t last_block_ = 0;
};

}  // namespace ddssec::cryptography
