// How long a step of the system's calendar is ignored (base/steady_calendar.hpp).
#pragma once

#include <chrono>

#include "plugins/spi/token.hpp"

namespace ddssec::spi {

/// Returns the value of `org.ddssec.clock_step_grace` in seconds, at most one hour;
/// SteadyCalendar::kDefaultGrace if the property is missing. With 0 a new calendar time counts at
/// once. Error: invalid_property.
Result<std::chrono::seconds> clock_step_grace(const PropertyList& properties);

}  // namespace ddssec::spi
