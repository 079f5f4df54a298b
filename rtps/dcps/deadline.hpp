// The DEADLINE period that the instance caches of writers and readers use.
#pragma once

#include <algorithm>

#include "base/clock.hpp"
#include "wire/time.hpp"

namespace ddssec::rtps {

/// Returns kNever if there is no deadline. A period below one millisecond is raised to one
/// millisecond, to avoid a busy loop.
inline MonotonicTime deadline_period(Duration period) {
  constexpr MonotonicTime kMin = std::chrono::milliseconds(1);
  return period.is_infinite() ? kNever : std::max(period.to_nanoseconds(), kMin);
}

}  // namespace ddssec::rtps
