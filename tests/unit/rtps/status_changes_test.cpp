// Changes of a status trigger its condition.
#include "rtps/dcps/status_changes.hpp"

#include <gmock/gmock.h>

#include "rtps/dcps/entity.hpp"
#include "rtps/dcps/read_conditions.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"
#include "tests/unit/rtps/dcps_parts.hpp"

namespace ddssec::rtps::dcps_parts {
namespace {

using namespace testing;

TEST_F(StatusChangesTest, Noted_TriggersItsCondition_UntilCleared) {
  auto& condition = entity.status_condition();
  entity.changes_.note(StatusKind::sample_lost);
  EXPECT_TRUE(condition.trigger_value());
  EXPECT_TRUE(entity.changes_.contains(StatusKind::sample_lost));
  condition.set_enabled_statuses(StatusKind::sample_rejected);
  EXPECT_FALSE(condition.trigger_value());
  condition.set_enabled_statuses(kAnyStatus);
  EXPECT_TRUE(condition.trigger_value());
  entity.changes_.clear(StatusKind::sample_lost);
  EXPECT_FALSE(condition.trigger_value());
  EXPECT_FALSE(entity.changes_.contains(StatusKind::sample_lost));
}

}  // namespace
}  // namespace ddssec::rtps::dcps_parts
