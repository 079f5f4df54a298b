// DEADLINE as the two caches of instances count it.
#pragma once

#include "base/clock.hpp"
#include "wire/time.hpp"

namespace ddssec::rtps {

/// kNever without a deadline. A request for less than a millisecond gets that, not a loop that
/// never rests.
inline MonotonicTime deadline_period(Duration period) {
  constexpr MonotonicTime kShortest = std::chrono::milliseconds(1);
  return period.is_infinite() ? kNever : std::max(period.to_nanoseconds(), kShortest);
}

}  // namespace ddssec::rtps
