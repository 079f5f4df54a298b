// Conditions alone; what a WaitSet does with them is in wait_set_test.cpp.
#include "rtps/dcps/condition.hpp"

#include <gmock/gmock.h>

#include "rtps/dcps/entity.hpp"
#include "rtps/dcps/wait_set.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"
#include "tests/unit/rtps/dcps_parts.hpp"

namespace ddssec::rtps::dcps_parts {
namespace {

using namespace testing;
using ::testing::IsEmpty;

TEST(GuardCondition, TriggerValue_StaysUntilItIsSetAgain) {
  GuardCondition condition;
  EXPECT_FALSE(condition.trigger_value());
  condition.set_trigger_value(true);
  condition.set_trigger_value(true);
  EXPECT_TRUE(condition.trigger_value());
  condition.set_trigger_value(false);
  EXPECT_FALSE(condition.trigger_value());
}

TEST(GuardCondition, Destroyed_LeavesItsWaitSets) {
  WaitSet first, second;
  {
    GuardCondition condition;
    first.attach_condition(condition);
    second.attach_condition(condition);
  }
  EXPECT_THAT(first.conditions(), IsEmpty());
  EXPECT_THAT(second.conditions(), IsEmpty());
}

TEST_F(StatusChangesTest, StatusThatChangedBefore_CountsOnceItIsEnabled) {
  auto& condition = entity.status_condition();
  condition.set_enabled_statuses(StatusKind::sample_rejected);
  entity.changes_.note(StatusKind::sample_lost);
  EXPECT_FALSE(condition.trigger_value());
  condition.set_enabled_statuses(StatusKind::sample_lost);
  EXPECT_TRUE(condition.trigger_value());
  EXPECT_TRUE(condition.enabled_statuses() == StatusMask(StatusKind::sample_lost));
}

}  // namespace
}  // namespace ddssec::rtps::dcps_parts
