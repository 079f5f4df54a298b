#include "plugins/spi/clock_step_grace.hpp"

#include <gtest/gtest.h>

#include "base/steady_calendar.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::spi {
namespace {

Result<std::chrono::seconds> grace(std::string value) {
  return clock_step_grace({{std::string(property::kClockStepGrace), std::move(value), false}});
}

TEST(ClockStepGrace, SecondsUpToAnHour_AreRead) {
  EXPECT_EQ(clock_step_grace({}), SteadyCalendar::kDefaultGrace);
  EXPECT_EQ(grace("0"), std::chrono::seconds(0));
  EXPECT_EQ(grace("90"), std::chrono::seconds(90));
  EXPECT_EQ(grace("3600"), std::chrono::hours(1));
}

TEST(ClockStepGrace, LongerThanAnHour_IsRefused) {
  const auto refused = grace("3601");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code(), Code::invalid_property);
  EXPECT_EQ(refused.error().details().document, property::kClockStepGrace);
}

}  // namespace
}  // namespace ddssec::spi
