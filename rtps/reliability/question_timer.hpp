// When a writer that has not been heard is asked again what it has.
#pragma once

#include <algorithm>

#include "base/clock.hpp"

namespace ddssec::rtps {

/// Each wait is twice the last one.
class QuestionTimer {
 public:
  static constexpr MonotonicTime kFirstWait = std::chrono::milliseconds(50);
  static constexpr MonotonicTime kMaxWait = std::chrono::seconds(5);

  /// kNever: no question is due.
  MonotonicTime due() const { return due_; }
  void note_asked(MonotonicTime now) {
    due_ = now + wait_;
    wait_ = std::min(wait_ * 2, kMaxWait);
  }
  /// The writer was heard.
  void stop() { due_ = kNever; }

 private:
  MonotonicTime due_ = kNever;
  MonotonicTime wait_ = kFirstWait;
};

}  // namespace ddssec::rtps
