#include "plugins/spi/governance_change_time.hpp"

#include <gtest/gtest.h>

#include "plugins/spi/property_names.hpp"

namespace ddssec::spi {
namespace {

Result<std::chrono::seconds> change_time(std::string value) {
  return governance_change_time(
      {{std::string(property::kGovernanceChangeTime), std::move(value), false}});
}

TEST(GovernanceChangeTime, SecondsUpToAnHour_AreRead) {
  EXPECT_EQ(governance_change_time({}), std::chrono::minutes(1));
  EXPECT_EQ(change_time("0"), std::chrono::seconds(0));
  EXPECT_EQ(change_time("90"), std::chrono::seconds(90));
  EXPECT_EQ(change_time("3600"), std::chrono::hours(1));
}

TEST(GovernanceChangeTime, LongerThanAnHour_IsRefused) {
  const auto refused = change_time("3601");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code(), Code::invalid_property);
  EXPECT_EQ(refused.error().details().document, property::kGovernanceChangeTime);
}

}  // namespace
}  // namespace ddssec::spi
