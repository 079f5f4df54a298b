// LIFESPAN on the writer's side (DDS 1.4, 2.2.3.16). No I/O, clock or lock.
#pragma once

#include <functional>
#include <vector>

#include "base/clock.hpp"
#include "wire/numbers.hpp"
#include "wire/time.hpp"

namespace ddssec::rtps {

class WriterHistory;

/// Tracks when each change of a writer expires.
class WriterLifespan {
 public:
  /// Adds a change that is written now.
  void add(SequenceNumber change, Duration lifespan, MonotonicTime now);
  /// Adds a change that expires at `at`. kNever means that it does not expire.
  void add(SequenceNumber change, MonotonicTime at);
  /// Calls `expired` once for each change that has expired.
  void expire(MonotonicTime now, const std::function<void(SequenceNumber)>& expired);
  /// Forgets changes that are not in the history any more, once there are more of them than others.
  /// The cost for each change does not depend on their number.
  void forget_dropped(const WriterHistory& history);
  /// Returns kNever if no change expires.
  MonotonicTime next_tick() const { return expiring_.empty() ? kNever : expiring_.front().first; }
  std::size_t size() const { return expiring_.size(); }

 private:
  using Expiring = std::pair<MonotonicTime, SequenceNumber>;
  /// A heap with the next one first. It is not a queue, because after a change of policy a later
  /// change may expire earlier.
  std::vector<Expiring> expiring_;
};

}  // namespace ddssec::rtps
