// Whether a small sample waits for more, so that they share a message.
#pragma once

#include <algorithm>

#include "rtps/qos/qos.hpp"
#include "rtps/reliability/piggyback_heartbeats.hpp"

namespace ddssec::rtps {

/// A sample waits if LATENCY_BUDGET allows it, or if the writer writes so quickly that it waits for
/// no answer. One that carries a question does not wait.
class WritePace {
 public:
  /// How long a sample waits at most without a budget.
  static constexpr MonotonicTime kLinger = std::chrono::microseconds(100);
  /// Of LATENCY_BUDGET no more than this is used.
  static constexpr MonotonicTime kMaxBudget = std::chrono::milliseconds(100);
  /// A writer that writes so many samples so quickly, and hears none between them, waits for no
  /// answer.
  static constexpr MonotonicTime kQuick = std::chrono::microseconds(50);
  static constexpr int kQuickWrites = 3;

  void set_budget(const Duration& budget) {
    budget_ = budget.is_infinite() ? kMaxBudget : std::min(budget.to_nanoseconds(), kMaxBudget);
  }
  /// `samples_heard`: how many samples the participant has heard until now.
  void note_write(MonotonicTime now, std::uint32_t samples_heard) {
    const bool quick = now - last_write_ < kQuick && samples_heard == samples_heard_;
    quick_writes_ = quick ? std::min(quick_writes_ + 1, kQuickWrites) : 0;
    last_write_ = now;
    samples_heard_ = samples_heard;
  }
  /// Whether the sample that was noted last may wait, with that heartbeat on it.
  bool may_wait(PiggybackHeartbeats::Kind heartbeat) const {
    using enum PiggybackHeartbeats::Kind;
    return (quick_writes_ == kQuickWrites && heartbeat == none) ||
           (budget_ > MonotonicTime::zero() && heartbeat != question);
  }
  MonotonicTime longest_wait() const { return std::max(kLinger, budget_); }

 private:
  MonotonicTime budget_{};
  MonotonicTime last_write_{};
  std::uint32_t samples_heard_ = 0;  ///< when last_write_ was
  int quick_writes_ = 0;             ///< in a row
};

}  // namespace ddssec::rtps
