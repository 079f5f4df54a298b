// Limits the octets that are sent to readers whose requests or addresses can be forged.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>

#include "base/clock.hpp"

namespace ddssec::rtps {

/// Allows kAtOnce octets at once, and kPerMillisecond more in each millisecond.
template <std::size_t kAtOnce, std::size_t kPerMillisecond>
class OctetAllowance {
 public:
  static constexpr std::size_t kMaxOctets = kAtOnce;
  static constexpr std::size_t kOctetsPerMillisecond = kPerMillisecond;

  /// Returns the number of octets that are left now.
  std::size_t renewed(MonotonicTime now) {
    using std::chrono::microseconds;
    constexpr std::int64_t kFull = (kAtOnce / kPerMillisecond + 1) * 1000;
    const auto passed = std::clamp<std::int64_t>((now - since_) / microseconds(1), 0, kFull);
    if (passed > 0) since_ = now;
    left_ = std::min(kAtOnce, left_ + static_cast<std::size_t>(passed) * kPerMillisecond / 1000);
    return left_;
  }
  void spend(std::size_t octets) { left_ -= std::min(left_, octets); }

 private:
  std::size_t left_ = kAtOnce;
  MonotonicTime since_{};
};

/// The allowance of each reader for repeated samples. If requests are not protected, an attacker
/// can send them in the reader's name and use the writer to flood the reader. Without a limit, one
/// datagram with many requests was answered with 338 times its octets.
using RepairAllowance = OctetAllowance<std::size_t{256} << 10, std::size_t{128} << 10>;

/// The allowance for history, for all best-effort readers of a writer together. Such readers do not
/// request it at their own pace, and a participant can announce any number of them at any address.
/// Without a limit, an announcement of 600 octets was answered with everything that the writer
/// held.
using HistoryAllowance = OctetAllowance<std::size_t{4} << 20, std::size_t{1} << 10>;

/// The allowance for readers' filters that a writer evaluates when it repeats samples or sends
/// history, for all readers together. It counts evaluation_price. One evaluation takes up to 13 us
/// (WriterFilter::kMaxSteps), so this is a fifth of a processor. Without a limit, a request of 152
/// octets made the writer compute for 3.3 ms, or for 60 ms if the samples were large.
using EvaluationAllowance = OctetAllowance<4096, 16>;

/// Returns the price of an evaluation. The sample must be decoded first, which takes longer
/// for larger samples.
constexpr std::size_t evaluation_price(std::size_t octets) { return 1 + octets / 1024; }

/// Larger samples are repeated without an evaluation, and their readers decide.
inline constexpr std::size_t kMaxEvaluatedOctets = std::size_t{1} << 20;

}  // namespace ddssec::rtps
