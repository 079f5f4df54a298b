// Sets of a whole group.
#include "rtps/dcps/groups.hpp"

#include "tests/support/succeeds.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"
#include "tests/unit/rtps/presenting.hpp"

namespace ddssec::rtps::presenting {
namespace {

using namespace std::chrono_literals;
using test::succeeds;
using testing::code_of;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST_P(Presenting, AGroupsSet_ComesAsAWholeToAllReaders) {
  const Presentation access{PresentationScope::group, true, true};
  auto& pub = publisher(access);
  auto& sub = subscriber(access);
  auto& other_a = **a.participant->create_topic<Reading>("Others");
  auto& other_b = **b.participant->create_topic<Reading>("Others");
  auto& one = writer_on(*a.topic, pub);
  auto& two = writer_on(other_a, pub);
  auto& of_one = reader_on(*b.topic, sub);
  auto& of_two = reader_on(other_b, sub);
  ASSERT_TRUE(match(one, of_one));
  ASSERT_TRUE(match(two, of_two));
  EXPECT_FALSE(of_one.take_next_sample());
  Samples<Reading> samples;
  EXPECT_EQ(code_of(of_one.take(samples)), Code::rtps_precondition_not_met);
  const auto take_all = [&] {
    std::vector<std::int64_t> out;
    EXPECT_TRUE(succeeds(sub.begin_access()));
    for (auto* reader : sub.datareaders()) {
      auto& typed = *static_cast<DataReader<Reading>*>(reader);
      EXPECT_EQ(typed.take(samples, 1), 1u);
      if (samples[0].info.valid_data) out.push_back(samples[0].data.value);
    }
    EXPECT_TRUE(succeeds(sub.end_access()));
    return out;
  };
  ASSERT_TRUE(succeeds(pub.begin_coherent_changes()));
  ASSERT_TRUE(succeeds(one.write({"a", 1})));
  ASSERT_TRUE(succeeds(two.write({"a", 2})));
  ASSERT_TRUE(succeeds(one.write({"b", 3})));
  ASSERT_TRUE(succeeds(two.write({"b", 4})));
  run(20ms);
  EXPECT_THAT(take_all(), IsEmpty());
  ASSERT_TRUE(succeeds(pub.end_coherent_changes()));
  run(20ms);
  EXPECT_THAT(take_all(), ElementsAre(1, 2, 3, 4));
  ASSERT_TRUE(succeeds(pub.begin_coherent_changes()));
  ASSERT_TRUE(succeeds(two.write({"a", 5})));  // the other writer has nothing in this set
  ASSERT_TRUE(succeeds(pub.end_coherent_changes()));
  ASSERT_TRUE(succeeds(one.write({"a", 6})));  // this sample is in no set
  run(20ms);
  EXPECT_THAT(take_all(), ElementsAre(5, 6));
}

}  // namespace
}  // namespace ddssec::rtps::presenting
