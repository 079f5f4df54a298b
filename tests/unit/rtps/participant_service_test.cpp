// A participant without a thread. The threads that wait serve it.
#include "rtps/dcps/participant_service.hpp"

#include "rtps/reliability/stateful_reader.hpp"
#include "tests/support/succeeds.hpp"
#include "tests/unit/rtps/accesses.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps::accesses {
namespace {

using namespace std::chrono_literals;
using test::succeeds;
using ::testing::ElementsAre;
using testing::taken;

TEST_P(Access, Waiting_ServesAParticipantWithoutAThread) {
  ASSERT_TRUE(succeeds(writer.write({"a", 1})));
  const bool delivered = GetParam() == testing::Way::in_process;
  EXPECT_EQ(writer.wait_for_acknowledgments(1ms).has_value(), delivered);
  EXPECT_TRUE(reader.wait_for_unread(1s));
  EXPECT_TRUE(succeeds(writer.wait_for_acknowledgments(1s)));
  EXPECT_TRUE(succeeds(a.publisher->wait_for_acknowledgments(0ms)));
  EXPECT_THAT(taken(reader), ElementsAre(1));
  EXPECT_FALSE(reader.wait_for_unread(1ms));
}

}  // namespace
}  // namespace ddssec::rtps::accesses
