// The time of a writer's next HEARTBEAT (heartbeatPeriod of RTPS 8.4.7.1).
#pragma once

#include <algorithm>

#include "base/clock.hpp"

namespace ddssec::rtps {

/// HEARTBEATs are sent as long as readers lack something, and less often while no reader answers.
class HeartbeatSchedule {
 public:
  static constexpr MonotonicTime kFirstPeriod = std::chrono::milliseconds(100);
  static constexpr MonotonicTime kMaxPeriod = std::chrono::milliseconds(1000);
  static constexpr int kMaxUnanswered = 5;  ///< after these, the period becomes longer

  /// Returns the time of the next HEARTBEAT; kNever if none is due.
  MonotonicTime due() const { return due_; }
  /// Schedules the next one after one period.
  void restart(MonotonicTime now) {
    period_ = kFirstPeriod;
    due_ = now + period_;
  }
  /// Notes that a sample was written.
  void note_written(MonotonicTime now) {
    if (due_ == kNever || period_ != kFirstPeriod) restart(now);
  }
  /// Notes a request: the reader is alive and needs the writer. So the next HEARTBEAT is sent soon,
  /// whatever the current period is.
  void note_request(MonotonicTime now) {
    unanswered_ = 0;
    period_ = kFirstPeriod;
    due_ = std::min(due_, now + period_);
  }
  /// Notes that the HEARTBEAT that was due was sent. If `all_acknowledged`, no other follows.
  void note_sent(MonotonicTime now, bool all_acknowledged) {
    if (++unanswered_ > kMaxUnanswered) period_ = std::min(period_ * 2, kMaxPeriod);
    due_ = all_acknowledged ? kNever : now + period_;
  }
  /// Notes that a reader answered.
  void note_answer(MonotonicTime now, bool all_acknowledged) {
    if (all_acknowledged)
      due_ = kNever;
    else if (due_ == kNever)
      due_ = now + kFirstPeriod;
  }

 private:
  MonotonicTime due_ = kNever;
  MonotonicTime period_{};
  int unanswered_ = 0;  ///< number of HEARTBEATs since a reader was heard
};

}  // namespace ddssec::rtps
