// The time at which a writer that has not been heard is queried again.
#pragma once

#include <algorithm>

#include "base/clock.hpp"

namespace ddssec::rtps {

/// Each wait is twice as long as the previous one.
class QueryTimer {
 public:
  static constexpr MonotonicTime kFirstWait = std::chrono::milliseconds(50);
  static constexpr MonotonicTime kMaxWait = std::chrono::seconds(5);

  /// Returns the time of the next query; kNever if none is due.
  MonotonicTime due() const { return due_; }
  void note_query(MonotonicTime now) {
    due_ = now + wait_;
    wait_ = std::min(wait_ * 2, kMaxWait);
  }
  /// Stops the timer, because the writer was heard.
  void stop() { due_ = kNever; }

 private:
  MonotonicTime due_ = kNever;
  MonotonicTime wait_ = kFirstWait;
};

}  // namespace ddssec::rtps
