// LIFESPAN on the writer's side (DDS 1.4, 2.2.3.16). No I/O, clock or lock.
#pragma once

#include <functional>
#include <queue>

#include "base/clock.hpp"
#include "wire/numbers.hpp"
#include "wire/time.hpp"

namespace ddssec::rtps {

/// Tracks when each change of a writer expires.
class WriterLifespan {
 public:
  /// True if a sample of that age has already expired.
  static bool is_over(Duration lifespan, std::chrono::nanoseconds age) {
    return !lifespan.is_infinite() && age >= lifespan.to_nanoseconds();
  }
  /// Adds a change that is `age` old at `now`.
  void add(SequenceNumber change, Duration lifespan, MonotonicTime now,
           std::chrono::nanoseconds age = {});
  /// Calls `expired` once for each change that has expired.
  void expire(MonotonicTime now, const std::function<void(SequenceNumber)>& expired);
  /// Returns kNever if no change expires.
  MonotonicTime next_tick() const { return expiring_.empty() ? kNever : expiring_.top().first; }

 private:
  using Expiring = std::pair<MonotonicTime, SequenceNumber>;
  /// The next one first: a policy that changes may let a later change expire earlier.
  std::priority_queue<Expiring, std::vector<Expiring>, std::greater<>> expiring_;
};

}  // namespace ddssec::rtps
