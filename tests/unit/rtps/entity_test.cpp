// Status conditions of an entity.
#include "rtps/dcps/entity.hpp"

#include "rtps/reliability/stateful_reader.hpp"
#include "tests/support/succeeds.hpp"
#include "tests/unit/rtps/accesses.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps::accesses {
namespace {

using namespace std::chrono_literals;
using test::succeeds;
using testing::taken;

TEST_P(Access, StatusConditions_FollowTheStatusesTheyAreFor) {
  auto& condition = reader.status_condition();
  EXPECT_TRUE(reader.status_changes().contains(StatusKind::subscription_matched));
  EXPECT_TRUE(condition.trigger_value());
  condition.set_enabled_statuses(StatusKind::data_available);
  EXPECT_FALSE(condition.trigger_value());
  EXPECT_EQ(condition.enabled_statuses(), StatusMask(StatusKind::data_available));
  write("a", 1);
  EXPECT_TRUE(condition.trigger_value());
  EXPECT_TRUE(b.subscriber->status_changes().contains(StatusKind::data_on_readers));
  taken(reader);
  EXPECT_FALSE(condition.trigger_value());
  EXPECT_FALSE(b.subscriber->status_changes().contains(StatusKind::data_on_readers));
  const auto status = reader.subscription_matched_status();
  EXPECT_EQ(status.total_count_change, 1);
  EXPECT_EQ(status.last_remote, writer.guid());
  EXPECT_EQ(reader.subscription_matched_status().total_count_change, 0);
  ASSERT_TRUE(succeeds(a.publisher->delete_datawriter(writer)));
  run(50ms);
  const auto after = reader.subscription_matched_status();
  EXPECT_EQ(std::pair(after.current_count, after.current_count_change), std::pair(0, -1));
  EXPECT_EQ(after.total_count, 1);
}

}  // namespace
}  // namespace ddssec::rtps::accesses
