// How many octets of repeated samples one reader gets.
#pragma once

#include <algorithm>
#include <cstddef>

#include "base/clock.hpp"

namespace ddssec::rtps {

/// Where requests are not protected an attacker sends them in the reader's name, and may use the
/// writer to flood it: one datagram with many requests was answered by 338 times its octets.
class RepairAllowance {
 public:
  /// At once, and in each millisecond.
  static constexpr std::size_t kMaxOctets = std::size_t{256} << 10;
  static constexpr std::size_t kOctetsPerMillisecond = std::size_t{128} << 10;

  /// What is left now.
  std::size_t renewed(MonotonicTime now) {
    using std::chrono::microseconds;
    const auto passed = std::clamp<std::int64_t>((now - since_) / microseconds(1), 0, 10'000);
    if (passed > 0) since_ = now;
    left_ = std::min(kMaxOctets,
                     left_ + static_cast<std::size_t>(passed) * kOctetsPerMillisecond / 1000);
    return left_;
  }
  void spend(std::size_t octets) { left_ -= std::min(left_, octets); }

 private:
  std::size_t left_ = kMaxOctets;
  MonotonicTime since_{};
};

}  // namespace ddssec::rtps
