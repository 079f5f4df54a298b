// The parts of a DataWriter, each by itself: liveliness, lifespan, source timestamps, listeners.
#include <gmock/gmock.h>

#include "rtps/dcps/data_writer_listeners.hpp"
#include "rtps/dcps/offered_liveliness.hpp"
#include "rtps/dcps/source_timestamps.hpp"
#include "rtps/dcps/writer_lifespan.hpp"
#include "rtps/reliability/writer_history.hpp"
#include "tests/support/code_of.hpp"

namespace ddssec::rtps {
namespace {

using std::chrono::milliseconds;
using test::code_of;
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

struct WriterLifespanTest : ::testing::Test {
  WriterLifespan lifespan;
  std::vector<std::int64_t> expired_by(MonotonicTime now) {
    std::vector<std::int64_t> out;
    lifespan.expire(now, [&](SequenceNumber change) { out.push_back(change.value); });
    return out;
  }
};

TEST_F(WriterLifespanTest, Infinite_NothingExpires) {
  lifespan.add({1}, kDurationInfinite, milliseconds(0));
  EXPECT_EQ(lifespan.next_tick(), kNever);
  lifespan.add({2}, kNever);
  EXPECT_EQ(lifespan.next_tick(), kNever);
}

TEST_F(WriterLifespanTest, Finite_ChangesExpireOnceInOrder) {
  const auto lifetime = Duration::from(milliseconds(500));
  lifespan.add({1}, milliseconds(100));
  lifespan.add({2}, lifetime, milliseconds(0));
  lifespan.add({3}, lifetime, milliseconds(10));
  EXPECT_EQ(lifespan.next_tick(), milliseconds(100));
  EXPECT_THAT(expired_by(milliseconds(99)), IsEmpty());
  EXPECT_THAT(expired_by(milliseconds(509)), ElementsAre(1, 2));
  EXPECT_THAT(expired_by(milliseconds(510)), ElementsAre(3));
  EXPECT_EQ(lifespan.next_tick(), kNever);
}

TEST_F(WriterLifespanTest, Shortened_LaterChangesExpireBeforeEarlierOnes) {
  lifespan.add({1}, Duration::from(milliseconds(500)), milliseconds(0));
  lifespan.add({2}, Duration::from(milliseconds(10)), milliseconds(0));
  EXPECT_EQ(lifespan.next_tick(), milliseconds(10));
  EXPECT_THAT(expired_by(milliseconds(10)), ElementsAre(2));
  EXPECT_EQ(lifespan.next_tick(), milliseconds(500));
}

// A writer of 1 kHz with a lifespan of a day kept 1.4 GB of numbers.
TEST_F(WriterLifespanTest, ChangesLeftTheHistory_AreForgotten) {
  Qos qos;
  qos.history = {HistoryKind::keep_last, 2};
  WriterHistory history(qos);
  for (int i = 0; i < 10'000; ++i) {
    Change change;
    change.payload = Payload::copy_of(Bytes{1});
    lifespan.add(history.add(std::move(change)), Duration::from(std::chrono::hours(24)),
                 milliseconds(i));
    lifespan.forget_dropped(history);
    ASSERT_LE(lifespan.size(), 100U);
  }
  EXPECT_THAT(expired_by(std::chrono::hours(25)), ::testing::IsSupersetOf({9'999, 10'000}));
}

Time at(std::int32_t seconds) { return Time{{seconds, 0}}; }

TEST(SourceTimestampsTest, ByReception_AnyTime_IsTaken) {
  SourceTimestamps times;
  const auto order = DestinationOrderKind::by_reception;
  EXPECT_EQ(times.next(at(9), at(1), order), at(9));
  EXPECT_EQ(times.next(at(3), at(1), order), at(3));
  EXPECT_EQ(times.next({}, at(1), order), at(1));
}

TEST(SourceTimestampsTest, BySource_EarlierThanTheLast_IsRefusedOrRepeatsIt) {
  SourceTimestamps times;
  const auto order = DestinationOrderKind::by_source;
  EXPECT_EQ(times.next(at(9), at(1), order), at(9));
  EXPECT_EQ(code_of(times.next(at(8), at(1), order)), Code::rtps_bad_parameter);
  EXPECT_EQ(times.next({}, at(1), order), at(9));  // the calendar was set back
  EXPECT_EQ(times.next({}, at(10), order), at(10));
  EXPECT_EQ(times.not_before_last(at(4)), at(10));
  EXPECT_EQ(times.not_before_last(at(11)), at(11));
}

TEST(DataWriterListenersTest, NearestListenerForTheStatus_IsChosen) {
  struct OfPublisher final : PublisherListener {
  } of_publisher;
  struct OfParticipant final : DomainParticipantListener {
  } of_participant;
  struct Own final : DataWriterListener {
  } own;
  Listening<PublisherListener> publisher;
  Listening<DomainParticipantListener> participant;
  DataWriterListeners listeners(publisher, participant);
  const auto matched = StatusKind::publication_matched;
  EXPECT_EQ(listeners.for_status(matched), nullptr);
  participant = {&of_participant, kAnyStatus};
  EXPECT_EQ(listeners.for_status(matched), &of_participant);
  publisher = {&of_publisher, matched};
  EXPECT_EQ(listeners.for_status(matched), &of_publisher);
  EXPECT_EQ(listeners.for_status(StatusKind::liveliness_lost), &of_participant);
  listeners.set(&own, matched);
  EXPECT_EQ(listeners.for_status(matched), &own);
  listeners.set(nullptr, kAnyStatus);
  EXPECT_EQ(listeners.for_status(matched), &of_publisher);
}

}  // namespace
}  // namespace ddssec::rtps
