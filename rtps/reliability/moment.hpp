// A moment on both clocks.
#pragma once

#include "base/clock.hpp"
#include "wire/time.hpp"

namespace ddssec::rtps {

/// The same moment on both clocks.
struct Moment {
  MonotonicTime now{};
  Time wall{};
};

}  // namespace ddssec::rtps
