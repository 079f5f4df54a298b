// When a local participant's keys have served long enough: its limits, and where in them the keys
// that it has now end. Time and use are looked at once a second; no message pays for it.
#pragma once

#include "plugins/spi/key_limits.hpp"

namespace ddssec::cryptography {

class KeyLife {
 public:
  /// How often a host asks.
  static constexpr std::chrono::seconds kAsked{1};

  KeyLife() = default;
  explicit KeyLife(spi::KeyLimits limits) : limits_(limits) {}

  bool is_limited() const { return limits_.any(); }
  /// Keys were made now. By `chance`, a random number, they end somewhere in the last quarter of
  /// what the limits allow: participants that start together do not revise together.
  void begin(std::chrono::nanoseconds now, std::uint64_t chance);
  bool has_ended(std::chrono::nanoseconds now) const;
  /// Is it time to look how much they protected? Not sooner after they were made than former keys
  /// count, so that few revisions count at a time, however low the limit is.
  bool counts_blocks(std::chrono::nanoseconds now) const;
  bool is_used_up(std::uint64_t blocks) const { return blocks >= last_block_; }

 private:
  spi::KeyLimits limits_;
  std::chrono::nanoseconds earliest_{0}, end_{0};
  std::uint64_t last_block_ = 0;
};

}  // namespace ddssec::cryptography
