// Matched readers that may not yet be able to read what the local writers send.
#pragma once

#include <deque>
#include <map>
#include <optional>

#include "base/clock.hpp"
#include "base/ids.hpp"

namespace ddssec::rtps {

/// If any part of a topic is protected, another participant may receive its keys some time after
/// the local participant. Samples that a volatile writer sends before that are lost to the reader.
/// So a reliable reader counts as matched when the first message from it arrives, or after
/// kMatchTimeout.
class ReadinessQueue {
 public:
  static constexpr MonotonicTime kMatchTimeout = std::chrono::seconds(1);
  struct WaitingMatch {
    Guid writer, reader;
    MonotonicTime deadline;
  };

  void add(const Guid& writer, const Guid& reader, MonotonicTime now) {
    waiting_[{writer, reader}] = now + kMatchTimeout;
    pairs_.push_back({writer, reader, now + kMatchTimeout});
  }
  void remove(const Guid& writer, const Guid& reader) {
    waiting_.erase({writer, reader});
    while (!pairs_.empty() && !waits(pairs_.front())) pairs_.pop_front();
  }
  /// Removes and returns the next pair that has waited long enough.
  std::optional<WaitingMatch> take_due(MonotonicTime now) {
    if (next() > now) return std::nullopt;
    const auto due = pairs_.front();
    remove(due.writer, due.reader);
    return due;
  }
  MonotonicTime next() const { return pairs_.empty() ? kNever : pairs_.front().deadline; }

 private:
  bool waits(const WaitingMatch& pair) const {
    const auto at = waiting_.find({pair.writer, pair.reader});
    return at != waiting_.end() && at->second == pair.deadline;
  }

  /// The deadline of each pair that waits.
  std::map<std::pair<Guid, Guid>, MonotonicTime> waiting_;
  std::deque<WaitingMatch> pairs_;  ///< sorted by deadline; the first one waits, others may not
};

}  // namespace ddssec::rtps
