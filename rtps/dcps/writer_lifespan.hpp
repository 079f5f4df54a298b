// LIFESPAN as a DataWriter counts it (DDS 1.4, 2.2.3.16). No I/O, clock or lock.
#pragma once

#include <functional>

#include "base/clock.hpp"
#include "rtps/reliability/ring.hpp"
#include "wire/numbers.hpp"
#include "wire/time.hpp"

namespace ddssec::rtps {

/// When each change of a writer expires.
class WriterLifespan {
 public:
  /// True: a sample of that age is too old already.
  static bool is_over(Duration lifespan, std::chrono::nanoseconds age) {
    return !lifespan.is_infinite() && age >= lifespan.to_nanoseconds();
  }
  /// A change that is `age` old at `now`. Changes come in the order in which they expire.
  void add(SequenceNumber change, Duration lifespan, MonotonicTime now,
           std::chrono::nanoseconds age = {});
  /// Calls `expired` for each change whose time is over, once.
  void expire(MonotonicTime now, const std::function<void(SequenceNumber)>& expired);
  /// kNever: none expires.
  MonotonicTime next_tick() const { return expiring_.empty() ? kNever : expiring_.front().first; }

 private:
  Ring<std::pair<MonotonicTime, SequenceNumber>> expiring_;  ///< oldest first
};

}  // namespace ddssec::rtps
