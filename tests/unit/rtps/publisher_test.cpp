// Publications that are suspended.
#include "rtps/dcps/publisher.hpp"

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
using testing::reliable;
using testing::taken;

TEST_P(Presenting, SuspendedPublications_ComeWhenTheyAreResumed) {
  auto& writer = a.writer(reliable());
  auto& reader = b.reader(reliable());
  ASSERT_TRUE(match(writer, reader));
  ASSERT_TRUE(succeeds(a.publisher->suspend_publications()));
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(succeeds(writer.write({"a", i})));
  run();
  EXPECT_THAT(taken(reader), IsEmpty());
  ASSERT_TRUE(succeeds(a.publisher->resume_publications()));
  run(20ms);
  EXPECT_THAT(taken(reader), ElementsAre(0, 1, 2));
  EXPECT_EQ(code_of(a.publisher->resume_publications()), Code::rtps_precondition_not_met);
  EXPECT_EQ(code_of(a.publisher->end_coherent_changes()), Code::rtps_precondition_not_met);
}

}  // namespace
}  // namespace ddssec::rtps::presenting
