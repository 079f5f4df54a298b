// When the plain announcements of a participant's endpoints are read once more.
#pragma once

#include <algorithm>

#include "base/clock.hpp"

namespace ddssec::rtps {

/// Where neither discovery nor RTPS messages are protected, anyone can announce in a participant's
/// name that an endpoint has other policies, or has ended. The participant does not notice, and so
/// does not correct it. But its SEDP writers keep what it announced, and send it again to a reader
/// that requests it. Of an endpoint that has in truth ended or changed, they keep only the latest.
///
/// The pause grows, so that a participant with many short-lived endpoints does not send all of them
/// again each time.
class SecondReading {
 public:
  static constexpr MonotonicTime kMinPause = std::chrono::seconds(4);
  static constexpr MonotonicTime kMaxPause = std::chrono::seconds(256);

  /// Something that proves nothing has changed or ended an endpoint that was known.
  void note_change(MonotonicTime now) {
    if (due_ != kNever) return;
    if (now >= last_ + kMaxPause) pause_ = kMinPause;
    due_ = now + pause_;
  }
  /// Returns true if all announcements are to be read again now.
  bool take_due(MonotonicTime now) {
    if (now < due_) return false;
    due_ = kNever;
    last_ = now;
    pause_ = std::min(pause_ * 2, kMaxPause);
    return true;
  }
  MonotonicTime due() const { return due_; }

 private:
  MonotonicTime due_ = kNever;
  MonotonicTime last_{};
  MonotonicTime pause_ = kMinPause;
};

}  // namespace ddssec::rtps
