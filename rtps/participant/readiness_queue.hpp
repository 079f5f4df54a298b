// Matched readers that may not be able yet to read what our writers say.
#pragma once

#include <deque>
#include <map>
#include <optional>

#include "base/clock.hpp"
#include "base/ids.hpp"

namespace ddssec::rtps {

/// Where messages are protected, another participant may be able to read what we say only some time
/// after we can read it, and what a volatile writer sends meanwhile is lost to its reader. So a
/// reliable reader counts as matched when it is heard, or after kPatience.
class ReadinessQueue {
 public:
  static constexpr MonotonicTime kPatience = std::chrono::seconds(1);
  struct Pair {
    Guid writer, reader;
    MonotonicTime deadline;
  };

  void add(const Guid& writer, const Guid& reader, MonotonicTime now) {
    waiting_[{writer, reader}] = now + kPatience;
    pairs_.push_back({writer, reader, now + kPatience});
  }
  void remove(const Guid& writer, const Guid& reader) {
    waiting_.erase({writer, reader});
    while (!pairs_.empty() && !waits(pairs_.front())) pairs_.pop_front();
  }
  /// The next pair that has waited long enough, which leaves the queue.
  std::optional<Pair> take_due(MonotonicTime now) {
    if (next() > now) return std::nullopt;
    const auto due = pairs_.front();
    remove(due.writer, due.reader);
    return due;
  }
  MonotonicTime next() const { return pairs_.empty() ? kNever : pairs_.front().deadline; }

 private:
  bool waits(const Pair& pair) const {
    const auto at = waiting_.find({pair.writer, pair.reader});
    return at != waiting_.end() && at->second == pair.deadline;
  }

  std::map<std::pair<Guid, Guid>, MonotonicTime> waiting_;  ///< until when
  std::deque<Pair> pairs_;  ///< by their deadlines; some do not wait any more, the first one does
};

}  // namespace ddssec::rtps
