// A topic of another type.
#include "rtps/dcps/topic.hpp"

#include "tests/support/succeeds.hpp"
#include "tests/unit/rtps/accesses.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps::accesses {
namespace {

using namespace std::chrono_literals;
using test::succeeds;

TEST_P(Access, AnotherType_IsAnInconsistentTopic) {
  Heard heard;
  b.topic->set_listener(&heard);
  testing::End c(services, options());
  ASSERT_TRUE(succeeds(c.participant->delete_contained_entities()));
  auto* topic = *c.participant->create_topic("Readings", {.name = "Other"});
  auto* group = &c.participant->create_publisher();
  ASSERT_TRUE(group->create_datawriter(*topic));
  for (int i = 0; i < 100 && heard.calls.empty(); ++i) c.participant->poll(0ms), run(10ms);
  EXPECT_TRUE(heard.heard("topic"));
  EXPECT_EQ(b.topic->inconsistent_topic_status().total_count, 1);
  b.topic->set_listener(nullptr);
}

}  // namespace
}  // namespace ddssec::rtps::accesses
