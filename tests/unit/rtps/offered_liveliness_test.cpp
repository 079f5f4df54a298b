// The liveliness that a writer offers, for each kind.
#include "rtps/dcps/offered_liveliness.hpp"

#include <gmock/gmock.h>

#include "rtps/dcps/source_timestamps.hpp"
#include "rtps/dcps/writer_lifespan.hpp"

namespace ddssec::rtps {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

struct OfferedLivelinessTest : ::testing::Test {
  std::vector<MonotonicTime> announced;
  ManualLiveliness manual{[this](MonotonicTime now) { announced.push_back(now); }};
  TimerQueue timers;
  int lost_one = 0, lost_two = 0;
  OfferedLiveliness one{timers, manual, [this] { ++lost_one; }};
  OfferedLiveliness two{timers, manual, [this] { ++lost_two; }};

  static Liveliness policy(LivelinessKind kind, milliseconds lease) {
    return {kind, Duration::from(lease)};
  }
  void start_both(LivelinessKind kind) {
    one.start(policy(kind, milliseconds(300)), milliseconds(0));
    two.start(policy(kind, milliseconds(600)), milliseconds(0));
  }
};

TEST_F(OfferedLivelinessTest, Automatic_NoAssertion_IsNeverLost) {
  start_both(LivelinessKind::automatic);
  EXPECT_EQ(timers.next(), kNever);
  one.assert_at(milliseconds(1), true);
  EXPECT_THAT(announced, IsEmpty());
}

TEST_F(OfferedLivelinessTest, ManualByTopic_NoAssertion_IsLostOnce) {
  start_both(LivelinessKind::manual_by_topic);
  timers.run(milliseconds(299));
  EXPECT_EQ(lost_one, 0);
  timers.run(milliseconds(300));
  timers.run(milliseconds(599));
  EXPECT_EQ(lost_one, 1);
  EXPECT_EQ(lost_two, 0);
}

TEST_F(OfferedLivelinessTest, ManualByTopic_AssertedByOneWriter_SaysNothingOfTheOther) {
  start_both(LivelinessKind::manual_by_topic);
  one.assert_at(milliseconds(590), false);
  timers.run(milliseconds(610));
  EXPECT_EQ(lost_one, 0);
  EXPECT_EQ(lost_two, 1);
  EXPECT_THAT(announced, IsEmpty());
}

TEST_F(OfferedLivelinessTest, ManualByParticipant_AssertedByOneWriter_RenewsAll) {
  start_both(LivelinessKind::manual_by_participant);
  two.assert_at(milliseconds(290), false);
  timers.run(milliseconds(589));
  EXPECT_EQ(lost_one + lost_two, 0);
  timers.run(milliseconds(590));
  EXPECT_EQ(lost_one, 1);
}

TEST_F(OfferedLivelinessTest, ManualByParticipant_ManyWrites_AreAnnouncedThriceInTheShortestLease) {
  start_both(LivelinessKind::manual_by_participant);
  for (int at = 0; at < 300; at += 10) one.assert_at(milliseconds(at), false);
  EXPECT_THAT(announced, ElementsAre(milliseconds(0), milliseconds(100), milliseconds(200)));
  manual.assert_all(milliseconds(201), true);
  EXPECT_EQ(announced.back(), milliseconds(201));
}

TEST_F(OfferedLivelinessTest, ManualByParticipant_StoppedWriter_IsAssertedNoMore) {
  start_both(LivelinessKind::manual_by_participant);
  one.stop();
  two.stop();
  EXPECT_EQ(timers.next(), kNever);
  manual.assert_all(milliseconds(100), true);
  EXPECT_THAT(announced, IsEmpty());
}

}  // namespace
}  // namespace ddssec::rtps
