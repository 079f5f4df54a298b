// The samples that are visible during an access.
#include "rtps/dcps/subscriber.hpp"

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
using testing::taken;

// Each scope except GROUP has presenters of its own.
TEST_P(Presenting, CoherentSetDuringAnAccess_IsNotSeenAtAnyScope) {
  for (const auto scope :
       {PresentationScope::instance, PresentationScope::topic, PresentationScope::group}) {
    const Presentation access{scope, true, false};
    auto& pub = publisher(access);
    auto& sub = subscriber(access);
    auto& writer = writer_on(*a.topic, pub);
    auto& reader = reader_on(*b.topic, sub);
    ASSERT_TRUE(match(writer, reader));
    ASSERT_TRUE(succeeds(sub.begin_access()));
    ASSERT_TRUE(succeeds(sub.begin_access()));
    auto& late = reader_on(*b.topic, sub);
    ASSERT_TRUE(match(writer, late));
    ASSERT_TRUE(succeeds(pub.begin_coherent_changes()));
    ASSERT_TRUE(succeeds(writer.write({"a", 1})));
    ASSERT_TRUE(succeeds(writer.write({"a", 2})));
    ASSERT_TRUE(succeeds(pub.end_coherent_changes()));
    run(20ms);
    ASSERT_TRUE(succeeds(sub.end_access()));
    EXPECT_THAT(taken(reader), IsEmpty());
    EXPECT_THAT(taken(late), IsEmpty());
    ASSERT_TRUE(succeeds(sub.end_access()));
    run(20ms);
    ASSERT_TRUE(succeeds(sub.begin_access()));
    EXPECT_THAT(taken(reader), ElementsAre(1, 2));
    EXPECT_THAT(taken(late), ElementsAre(1, 2));
    ASSERT_TRUE(succeeds(sub.end_access()));
    ASSERT_TRUE(succeeds(pub.delete_contained_entities()));
    ASSERT_TRUE(succeeds(sub.delete_contained_entities()));
    run(50ms);
  }
}

TEST_P(Presenting, NewSamplesDuringAnAccess_AreNotSeen) {
  const Presentation access{PresentationScope::group, false, true};
  auto& pub = publisher(access);
  auto& sub = subscriber(access);
  auto& writer = writer_on(*a.topic, pub);
  auto& reader = reader_on(*b.topic, sub);
  ASSERT_TRUE(match(writer, reader));
  ASSERT_TRUE(succeeds(sub.begin_access()));
  ASSERT_TRUE(succeeds(writer.write({"a", 1})));
  run(20ms);
  EXPECT_THAT(taken(reader), IsEmpty());
  ASSERT_TRUE(succeeds(sub.end_access()));
  ASSERT_TRUE(succeeds(sub.begin_access()));
  EXPECT_THAT(taken(reader), ElementsAre(1));
  ASSERT_TRUE(succeeds(sub.end_access()));
  EXPECT_EQ(code_of(sub.end_access()), Code::rtps_precondition_not_met);
}

}  // namespace
}  // namespace ddssec::rtps::presenting
