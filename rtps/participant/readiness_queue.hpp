// Matched readers that may not be able yet to read what our writers say.
#pragma once

#include <algorithm>
#include <deque>
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
    pairs_.push_back({writer, reader, now + kPatience});
  }
  void remove(const Guid& writer, const Guid& reader) {
    std::erase_if(pairs_, [&](const Pair& p) { return p.writer == writer && p.reader == reader; });
  }
  /// The next pair that has waited long enough, which leaves the queue.
  std::optional<Pair> take_due(MonotonicTime now) {
    if (next() > now) return std::nullopt;
    const auto due = pairs_.front();
    pairs_.pop_front();
    return due;
  }
  MonotonicTime next() const { return pairs_.empty() ? kNever : pairs_.front().deadline; }

 private:
  std::deque<Pair> pairs_;  ///< by their deadlines
};

}  // namespace ddssec::rtps
