// Decides whether a small sample waits for more, so that they share a message.
#pragma once

#include <algorithm>

#include "rtps/qos/qos.hpp"
#include "rtps/reliability/piggyback_heartbeats.hpp"

namespace ddssec::rtps {

/// A sample waits if LATENCY_BUDGET allows it, or if the writer writes so fast that it cannot be
/// waiting for answers. A sample with a HEARTBEAT without FinalFlag does not wait.
class WritePace {
 public:
  /// The longest wait of a sample without a budget.
  static constexpr MonotonicTime kLinger = std::chrono::microseconds(100);
  /// At most this much of LATENCY_BUDGET is used.
  static constexpr MonotonicTime kMaxBudget = std::chrono::milliseconds(100);
  /// A writer that writes kQuickWrites samples at intervals below kQuick, and receives none between
  /// them, does not wait for answers.
  static constexpr MonotonicTime kQuick = std::chrono::microseconds(50);
  static constexpr int kQuickWrites = 3;

  void set_budget(const Duration& budget) {
    budget_ = budget.is_infinite() ? kMaxBudget : std::min(budget.to_nanoseconds(), kMaxBudget);
  }
  /// `samples_heard` is the number of samples that the participant has received until now.
  void note_write(MonotonicTime now, std::uint32_t samples_heard) {
    const bool quick = now - last_write_ < kQuick && samples_heard == samples_heard_;
    quick_writes_ = quick ? std::min(quick_writes_ + 1, kQuickWrites) : 0;
    last_write_ = now;
    samples_heard_ = samples_heard;
  }
  /// True if the last sample, which carries `heartbeat`, may wait.
  bool may_wait(PiggybackHeartbeats::Kind heartbeat) const {
    using enum PiggybackHeartbeats::Kind;
    return (quick_writes_ == kQuickWrites && heartbeat == none) ||
           (budget_ > MonotonicTime::zero() && heartbeat != without_final);
  }
  MonotonicTime longest_wait() const { return std::max(kLinger, budget_); }

 private:
  MonotonicTime budget_{};
  MonotonicTime last_write_{};
  std::uint32_t samples_heard_ = 0;  ///< the value at last_write_
  int quick_writes_ = 0;             ///< consecutive fast writes
};

}  // namespace ddssec::rtps
