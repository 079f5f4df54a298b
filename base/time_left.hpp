// The end of a document in words.
#pragma once

#include <string>

#include "base/clock.hpp"

namespace ddssec {

/// Formats an end with its distance from `now`: "2026-12-04T03:00:00Z, in 6 days", or "..., 6 days
/// ago"; in hours, minutes or seconds if the distance is less than a day.
std::string in_time(WallTime end, WallTime now);

}  // namespace ddssec
