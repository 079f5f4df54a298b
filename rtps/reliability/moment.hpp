// A moment on both clocks.
#pragma once

#include <algorithm>
#include <optional>

#include "base/clock.hpp"
#include "wire/time.hpp"

namespace ddssec::rtps {

/// One moment, as monotonic time and as calendar time.
struct Moment {
  MonotonicTime now{};
  Time wall{};
};

/// Returns the time at which the LIFESPAN of a sample ends (DDS 1.4, 2.2.3.16). It counts from the
/// source time. If the writer's clock is ahead of the local one, its samples still get no more than
/// the lifespan.
inline MonotonicTime end_of_life(const std::optional<Time>& source, Duration lifespan,
                                 const Moment& at) {
  if (lifespan.is_infinite()) return kNever;
  const auto end = at.now + lifespan.to_nanoseconds();
  if (!source) return end;
  const auto age = at.wall.to_nanoseconds() - source->to_nanoseconds();
  return end - std::max(age, std::chrono::nanoseconds::zero());
}

}  // namespace ddssec::rtps
