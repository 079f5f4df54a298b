// Instances of a writer and their deadlines.
#include "rtps/dcps/writer_instances.hpp"

#include <gmock/gmock.h>

#include "tests/unit/rtps/wire_helpers.hpp"

namespace ddssec::rtps {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAre;

constexpr KeyHash kOne{1}, kTwo{2}, kThree{3};

TEST(WriterInstances, EachInstance_IsRegisteredLookedUpAndForgotten) {
  Qos qos;
  qos.resource_limits.max_instances = 2;
  WriterInstances instances(qos);
  const auto one = instances.enter(kOne, [] { return Bytes{7}; });
  EXPECT_FALSE(one.is_nil());
  EXPECT_EQ(instances.enter(kOne, nullptr), one);
  EXPECT_EQ(instances.lookup(kOne), one);
  EXPECT_EQ(*instances.key_value(one), Bytes{7});
  EXPECT_FALSE(instances.enter(kTwo, nullptr).is_nil());
  EXPECT_TRUE(instances.enter(kThree, nullptr).is_nil());
  instances.remove(kOne);
  EXPECT_EQ(instances.key_value(one), nullptr);
  EXPECT_FALSE(instances.enter(kThree, nullptr).is_nil());
  EXPECT_EQ(instances.size(), 2u);
}

TEST(WriterInstances, Deadlines_RunFromTheLastWrite) {
  Qos qos;
  qos.deadline = Duration::from(milliseconds(100));
  WriterInstances instances(qos);
  const auto one = instances.enter(kOne, nullptr), two = instances.enter(kTwo, nullptr);
  instances.note_written(kOne, milliseconds(0));
  instances.note_written(kTwo, milliseconds(50));
  instances.note_written(kOne, milliseconds(60));
  EXPECT_EQ(instances.next_deadline(), milliseconds(150));
  std::vector<InstanceHandle> missed;
  const auto check = [&](MonotonicTime now) {
    instances.expire_deadlines(now, [&](auto instance) { missed.push_back(instance); });
  };
  check(milliseconds(155));
  EXPECT_THAT(missed, ElementsAre(two));
  instances.note_disposed(kTwo);
  check(milliseconds(300));
  EXPECT_THAT(missed, ElementsAre(two, one));
  instances.set_deadline(Duration::from(milliseconds(10)), milliseconds(300));
  EXPECT_EQ(instances.next_deadline(), milliseconds(310));
  instances.set_deadline(kDurationInfinite, milliseconds(300));
  EXPECT_EQ(instances.next_deadline(), kNever);
}

}  // namespace
}  // namespace ddssec::rtps
