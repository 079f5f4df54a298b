// How long a calendar that was set is not believed (base/steady_calendar.hpp).
#pragma once

#include <chrono>

#include "plugins/spi/token.hpp"

namespace ddssec::spi {

/// What `org.ddssec.clock_step_grace` says, at most an hour; 0: the calendar counts at once. Error:
/// invalid_property.
Result<std::chrono::seconds> clock_step_grace(const PropertyList& properties);

}  // namespace ddssec::spi
