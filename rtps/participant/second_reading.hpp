// When the plain announcements of a participant's endpoints are read once more.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "base/ids.hpp"

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
  /// How long the answer may take.
  static constexpr MonotonicTime kPatience = std::chrono::seconds(4);
  /// Limit for the endpoints that have ended and may come back.
  static constexpr std::size_t kMaxEnded = 64;

  /// Something that proves nothing has changed an endpoint that was known.
  void note_change(MonotonicTime now) {
    if (due_ != kNever) return;
    if (now >= last_ + kMaxPause) pause_ = kMinPause;
    due_ = now + pause_;
  }
  /// The same, and the endpoint has ended. Returns false if its keys cannot be kept.
  bool note_end(const EntityId& endpoint, MonotonicTime now) {
    note_change(now);
    if (ended_.size() + read_.size() >= kMaxEnded) return false;
    ended_.push_back(endpoint);
    return true;
  }
  /// Returns true if all announcements are to be read again now.
  bool take_due(MonotonicTime now) {
    if (now < due_) return false;
    due_ = kNever;
    last_ = now;
    pause_ = std::min(pause_ * 2, kMaxPause);
    read_.insert(read_.end(), ended_.begin(), ended_.end());
    ended_.clear();
    if (!read_.empty()) over_ = now + kPatience;
    return true;
  }
  /// Returns the endpoints that had ended before the latest reading, if that is over: those that
  /// have not come back by now do not.
  std::vector<EntityId> take_read(MonotonicTime now) {
    if (now < over_) return {};
    over_ = kNever;
    return std::exchange(read_, {});
  }
  MonotonicTime due() const { return due_; }
  /// Nothing is to be taken before this time.
  MonotonicTime next() const { return std::min(due_, over_); }

 private:
  MonotonicTime due_ = kNever, over_ = kNever;
  MonotonicTime last_{};
  MonotonicTime pause_ = kMinPause;
  std::vector<EntityId> ended_, read_;  ///< since the latest reading, and before it
};

}  // namespace ddssec::rtps
