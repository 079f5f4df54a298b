#include "plugins/spi/clock_step_grace.hpp"

#include "base/steady_calendar.hpp"
#include "plugins/spi/number_property.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::spi {

Result<std::chrono::seconds> clock_step_grace(const PropertyList& properties) {
  DDSSEC_ASSIGN_OR_RETURN(
      const auto seconds,
      number_property(properties, property::kClockStepGrace,
                      {.unit = "seconds", .max = SteadyCalendar::kMaxGrace.count()},
                      SteadyCalendar::kDefaultGrace.count()));
  return std::chrono::seconds(seconds);
}

}  // namespace ddssec::spi
