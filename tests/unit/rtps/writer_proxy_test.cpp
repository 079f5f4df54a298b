#include "rtps/reliability/writer_proxy.hpp"

#include <ctime>

#include <gmock/gmock.h>

#include "tests/support/slowdown.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"

namespace ddssec::rtps {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

const Guid kGuid{GuidPrefix::from(Bytes(12, 0xaa)), testing::kWriter};

Heartbeat heartbeat(std::int64_t first, std::int64_t last, std::int32_t count) {
  return {{}, testing::kWriter, {first}, {last}, count};
}

struct WriterProxyTest : ::testing::Test {
  std::vector<std::int64_t> delivered;
  std::int64_t refuses_from = 1'000'000, lost = 0;
  WriterProxy::Common common{.deliver =
                                 [this](Change& change) {
                                   if (change.sequence_number.value >= refuses_from) return false;
                                   delivered.push_back(change.sequence_number.value);
                                   return true;
                                 },
                             .lost = [this](std::int64_t count) { lost += count; }};
  WriterProxy reliable{{.guid = kGuid, .is_reliable = true}, true, common};
  WriterProxy best_effort{{.guid = kGuid, .is_reliable = true}, false, common};

  static bool add(WriterProxy& proxy, std::int64_t number, KeyAge age = KeyAge::newest) {
    Change change;
    change.sequence_number = {number};
    return proxy.accept({number}, std::move(change), age);
  }
  static std::vector<std::int64_t> missing(const WriterProxy& proxy, std::int64_t last) {
    std::vector<std::int64_t> out;
    proxy.missing(proxy.next(), {last}).for_each([&](SequenceNumber number) {
      out.push_back(number.value);
    });
    return out;
  }
};

TEST_F(WriterProxyTest, EarlyChanges_AreDeliveredInTheirTurn) {
  EXPECT_TRUE(add(reliable, 3));
  EXPECT_FALSE(add(reliable, 3));
  EXPECT_TRUE(add(reliable, 2));
  EXPECT_THAT(delivered, IsEmpty());
  EXPECT_THAT(missing(reliable, 5), ElementsAre(1, 4, 5));
  EXPECT_TRUE(add(reliable, 1));
  EXPECT_THAT(delivered, ElementsAre(1, 2, 3));
  EXPECT_EQ(common.held->octets(), 0u);
}

TEST_F(WriterProxyTest, BestEffort_GoesOnlyForward) {
  add(best_effort, 1);
  add(best_effort, 4);
  EXPECT_THAT(delivered, ElementsAre(1, 4));
  EXPECT_EQ(best_effort.next(), SequenceNumber{5});
  EXPECT_EQ(lost, 2);
  EXPECT_TRUE(best_effort.has_history());
}

TEST_F(WriterProxyTest, TooManyEarlyChanges_AreNotKept) {
  for (std::size_t i = 0; i < WriterProxy::kMaxEarlyChanges; ++i)
    EXPECT_TRUE(add(reliable, static_cast<std::int64_t>(i) + 2));
  EXPECT_FALSE(add(reliable, 100'000));
  EXPECT_EQ(reliable.early(), WriterProxy::kMaxEarlyChanges);
  EXPECT_TRUE(add(reliable, 1)) << "the next always has room";
}

// A HEARTBEAT of 32 octets took 18 us if the writer had sent many changes before the next one.
TEST_F(WriterProxyTest, ManyEarlyChanges_AreNotCountedForEachHeartbeat) {
  for (std::int64_t i = 0; i < 2000; ++i) add(reliable, i + 2);
  const auto count_often = [&](bool misses) {
    const auto begin = std::clock();
    for (int i = 0; i < 100'000; ++i) ASSERT_EQ(reliable.misses_any({2001}), misses);
    EXPECT_LT(std::clock() - begin, CLOCKS_PER_SEC * test::kSlowdown / 4);
  };
  count_often(true);
  refuses_from = 1;
  add(reliable, 1);
  count_often(false);
}

TEST_F(WriterProxyTest, ARefusedChange_IsOfferedAgain) {
  refuses_from = 2;
  for (const std::int64_t number : {1, 2, 3}) add(reliable, number);
  EXPECT_THAT(delivered, ElementsAre(1));
  EXPECT_FALSE(reliable.offer_again());
  EXPECT_FALSE(reliable.lacks({2}));
  refuses_from = 10;
  EXPECT_TRUE(reliable.offer_again());
  EXPECT_THAT(delivered, ElementsAre(1, 2, 3));
}

TEST_F(WriterProxyTest, ARefusedChange_IsRequestedAgainWheneverTheWriterSaidMore) {
  refuses_from = 2;
  for (const std::int64_t number : {1, 2, 3}) add(reliable, number);
  reliable.on_heartbeat(heartbeat(1, 3, 1), true, KeyAge::newest);
  EXPECT_EQ(reliable.forget_refused(), 0u);
  EXPECT_THAT(missing(reliable, 3), ElementsAre(2, 3));
  EXPECT_FALSE(reliable.forget_refused()) << "nothing was refused";
  for (const std::int64_t number : {2, 3}) add(reliable, number);
  EXPECT_FALSE(reliable.forget_refused()) << "the writer cannot have replaced it";
  reliable.on_heartbeat(heartbeat(1, 4, 2), true, KeyAge::newest);
  EXPECT_TRUE(reliable.forget_refused());
  refuses_from = 10;
  reliable.accept({2}, std::nullopt, KeyAge::newest);  // the writer has replaced it
  add(reliable, 3);
  EXPECT_THAT(delivered, ElementsAre(1, 3));
}

TEST_F(WriterProxyTest, AnOldHeartbeat_ChangesNothing) {
  EXPECT_TRUE(reliable.on_heartbeat(heartbeat(1, 3, 7), true, KeyAge::newest));
  EXPECT_FALSE(reliable.on_heartbeat(heartbeat(4, 9, 7), true, KeyAge::newest));
  EXPECT_FALSE(reliable.on_heartbeat(heartbeat(4, 9, 6), true, KeyAge::newest));
  EXPECT_EQ(reliable.next(), SequenceNumber{1});
  EXPECT_EQ(reliable.announced(), SequenceNumber{3});
  EXPECT_TRUE(reliable.on_heartbeat(heartbeat(4, 9, 8), true, KeyAge::newest));
  EXPECT_EQ(reliable.next(), SequenceNumber{4});
}

TEST_F(WriterProxyTest, WhatTheWriterNoLongerHas_IsLostAfterItsFirstHeartbeat) {
  reliable.on_heartbeat(heartbeat(3, 4, 1), true, KeyAge::newest);
  EXPECT_EQ(lost, 0) << "a late joiner never could have had it";
  add(reliable, 5);
  reliable.on_heartbeat(heartbeat(6, 6, 2), true, KeyAge::newest);
  EXPECT_EQ(lost, 2);
  EXPECT_THAT(delivered, ElementsAre(5));
}

// Otherwise they would be counted with each HEARTBEAT.
TEST_F(WriterProxyTest, WhatIsLostBehindARefusedChange_IsCountedOnce) {
  reliable.on_heartbeat(heartbeat(1, 5, 1), true, KeyAge::newest);
  refuses_from = 1;
  add(reliable, 1);
  for (int count = 2; count < 5; ++count)
    reliable.on_heartbeat(heartbeat(4, 5, count), true, KeyAge::newest);
  EXPECT_EQ(lost, 2);
  reliable.on_heartbeat(heartbeat(6, 6, 5), true, KeyAge::newest);
  EXPECT_EQ(lost, 4);
  refuses_from = 10;
  reliable.on_heartbeat(heartbeat(6, 6, 6), true, KeyAge::newest);
  EXPECT_EQ(lost, 4);
  EXPECT_THAT(delivered, ElementsAre(1));
}

// A full reader took some of the samples that it held, but not all of them. Those that it took are
// finished.
TEST_F(WriterProxyTest, WhatAFullReaderTook_IsNeitherLostNorTakenAgain) {
  reliable.on_heartbeat(heartbeat(1, 3, 1), true, KeyAge::newest);
  add(reliable, 2);
  add(reliable, 3);
  refuses_from = 3;
  for (int count = 2; count < 5; ++count)
    reliable.on_heartbeat(heartbeat(4, 4, count), true, KeyAge::newest);
  EXPECT_EQ(lost, 1) << "the first, once";
  EXPECT_FALSE(reliable.lacks({2})) << "whoever sends it again";
  refuses_from = 10;
  reliable.on_heartbeat(heartbeat(4, 4, 5), true, KeyAge::newest);
  EXPECT_THAT(delivered, ElementsAre(2, 3));
  EXPECT_EQ(reliable.next(), SequenceNumber{4});
}

TEST_F(WriterProxyTest, History_IsWhatItsFirstHeartbeatAnnounced) {
  EXPECT_FALSE(reliable.has_history());
  reliable.on_heartbeat(heartbeat(1, 2, 1), true, KeyAge::newest);
  reliable.on_heartbeat(heartbeat(1, 9, 2), true, KeyAge::newest);
  add(reliable, 1);
  EXPECT_FALSE(reliable.has_history());
  add(reliable, 2);
  EXPECT_TRUE(reliable.has_history());
}

TEST_F(WriterProxyTest, MissesAny_AsLongAsNotAllUpToTheLastIsHeld) {
  add(reliable, 2);
  EXPECT_TRUE(reliable.misses_any({2}));
  add(reliable, 1);
  EXPECT_FALSE(reliable.misses_any({2}));
  EXPECT_TRUE(reliable.misses_any({3}));
  reliable.accept({3}, std::nullopt, KeyAge::newest);
  EXPECT_FALSE(reliable.misses_any({3}));
}

TEST_F(WriterProxyTest, TheLatest_IsForgottenFirst) {
  add(reliable, 3);
  add(reliable, 5);
  DataFrag frag{{}, testing::kWriter, {4}, {1}, 1, 1000, 2000};
  reliable.partial().begin(kGuid.prefix, frag, {});
  reliable.forget_latest();
  EXPECT_TRUE(reliable.lacks({5}));
  EXPECT_FALSE(reliable.partial().empty());
  reliable.forget_latest();
  EXPECT_TRUE(reliable.partial().empty());
  EXPECT_FALSE(reliable.lacks({3}));
  reliable.forget_latest();
  EXPECT_EQ(reliable.held().octets(), 0u);
}

// Samples that were sent before it left are not new, whichever participant sends them again.
TEST_F(WriterProxyTest, Resumed_GoesOnWhereItWas) {
  reliable.resume({{}, {5}, 7}, false);
  EXPECT_EQ(reliable.next(), SequenceNumber{5});
  reliable.on_heartbeat(heartbeat(1, 4, 1), true, KeyAge::newest);
  const auto position = reliable.position({});
  EXPECT_EQ(position.next, SequenceNumber{5});
}

TEST_F(WriterProxyTest, ResumedWithHistory_WaitsForANewHeartbeat) {
  reliable.resume({{}, {5}, 7}, true);
  add(reliable, 1);
  add(reliable, 3);
  EXPECT_TRUE(reliable.waits_for_heartbeat());
  EXPECT_FALSE(reliable.on_heartbeat(heartbeat(1, 4, 7), true, KeyAge::newest))
      << "it was heard before";
  EXPECT_THAT(delivered, IsEmpty());
  EXPECT_TRUE(reliable.on_heartbeat(heartbeat(3, 4, 8), true, KeyAge::newest));
  EXPECT_THAT(delivered, ElementsAre(3)) << "the writer does not hold the first any more";
  EXPECT_FALSE(reliable.waits_for_heartbeat());
}

// The HEARTBEAT may have been recorded. But a forged one may have had the latest count, too, and
// then no honest one would ever be accepted.
TEST_F(WriterProxyTest, ResumedWithHistory_AnUnprotectedOldHeartbeatContinuesWhereItWas) {
  reliable.resume({{}, {5}, 7}, true);
  add(reliable, 1);
  add(reliable, 5);
  EXPECT_TRUE(reliable.on_heartbeat(heartbeat(1, 6, 7), false, KeyAge::newest));
  EXPECT_FALSE(reliable.waits_for_heartbeat());
  EXPECT_THAT(delivered, ElementsAre(5)) << "the first was delivered before";
}

TEST(QueryTimer, EachQuestion_WaitsTwiceAsLong) {
  QueryTimer timer;
  EXPECT_EQ(timer.due(), kNever);
  MonotonicTime now{};
  auto wait = QueryTimer::kFirstWait;
  for (int i = 0; i < 20; ++i, wait = std::min(2 * wait, QueryTimer::kMaxWait)) {
    timer.note_query(now);
    EXPECT_EQ(timer.due(), now + wait);
    now = timer.due();
  }
  EXPECT_EQ(wait, QueryTimer::kMaxWait);
  timer.stop();
  EXPECT_EQ(timer.due(), kNever);
}

// Others have sent in the writer's name, with its former keys, that everything below 2^40 is gone.
struct FormerKeysTest : WriterProxyTest {
  static constexpr std::int64_t kFar = std::int64_t{1} << 40;
  FormerKeysTest() {
    for (const std::int64_t number : {1, 2, 3}) add(reliable, number), add(best_effort, number);
    reliable.on_heartbeat(heartbeat(kFar, kFar, 0xfffff), true, KeyAge::newest);
    best_effort.skip_to({kFar}, KeyAge::newest);
    reliable.note_revised(), best_effort.note_revised();
  }
};

TEST_F(FormerKeysTest, NextHeartbeat_DecidesWhereTheWriterIs) {
  add(reliable, 4, KeyAge::former);
  EXPECT_FALSE(reliable.on_heartbeat(heartbeat(1, 5, 1), true, KeyAge::newest))
      << "before, its count is an old one";
  delivered.clear();
  reliable.distrust_former_keys();
  EXPECT_TRUE(reliable.on_heartbeat(heartbeat(1, 5, 2), true, KeyAge::newest));
  EXPECT_EQ(reliable.next(), SequenceNumber{4});
  EXPECT_THAT(missing(reliable, 5), ElementsAre(4, 5));
  add(reliable, 5), add(reliable, 4);
  EXPECT_THAT(delivered, ElementsAre(4, 5));
  EXPECT_TRUE(reliable.on_heartbeat(heartbeat(1, 5, 3), true, KeyAge::newest));
  EXPECT_EQ(reliable.next(), SequenceNumber{6}) << "once";
}

TEST_F(FormerKeysTest, AForgedChangeThatWasDelivered_HidesNoLaterOne) {
  refuses_from = kFar + 1;
  add(reliable, kFar, KeyAge::former);
  reliable.distrust_former_keys();
  EXPECT_TRUE(reliable.on_heartbeat(heartbeat(1, 5, 2), true, KeyAge::newest));
  EXPECT_EQ(reliable.next(), SequenceNumber{6}) << "what is before it may have been delivered";
}

TEST_F(FormerKeysTest, ChangesThatWereHeld_AreRequestedAgain) {
  WriterProxy proxy{{.guid = kGuid, .is_reliable = true}, true, common};
  add(proxy, 1), add(proxy, 3);
  proxy.distrust_former_keys();
  EXPECT_EQ(proxy.early(), 0u);
  EXPECT_TRUE(proxy.on_heartbeat(heartbeat(1, 3, 1), true, KeyAge::newest));
  EXPECT_THAT(missing(proxy, 3), ElementsAre(2, 3));
}

TEST_F(FormerKeysTest, BestEffort_TakesTheNextChange) {
  delivered.clear();
  best_effort.distrust_former_keys();
  EXPECT_EQ(best_effort.next(), SequenceNumber{1});
  add(best_effort, 4);
  EXPECT_THAT(delivered, ElementsAre(4));
  EXPECT_EQ(best_effort.next(), SequenceNumber{5});
}

// A writer that has revised its keys. Anyone may have recorded what it sends under the newest ones.
struct NewestKeysTest : WriterProxyTest {
  NewestKeysTest() {
    for (auto* proxy : {&reliable, &best_effort}) {
      for (const std::int64_t number : {1, 2}) add(*proxy, number);
      proxy->note_revised();
      for (const std::int64_t number : {3, 4, 5}) add(*proxy, number);
      proxy->on_heartbeat(heartbeat(1, 5, 10), true, KeyAge::newest);
    }
    delivered.clear();
  }
};

TEST_F(NewestKeysTest, FormerKeysEnd_WhatCameUnderTheNewestStaysTaken) {
  add(best_effort, 1000, KeyAge::former), add(reliable, 6, KeyAge::former);
  reliable.distrust_former_keys(), best_effort.distrust_former_keys();
  EXPECT_EQ(best_effort.next(), SequenceNumber{6});
  EXPECT_FALSE(reliable.on_heartbeat(heartbeat(1, 3, 9), true, KeyAge::newest))
      << "it was repeated";
  EXPECT_TRUE(reliable.on_heartbeat(heartbeat(1, 4, 11), true, KeyAge::newest)) << "it is late";
  EXPECT_GE(reliable.next(), SequenceNumber{6});
}

TEST_F(NewestKeysTest, HeldUnderTheNewest_IsRequestedAgain) {
  add(reliable, 8);
  reliable.distrust_former_keys();
  EXPECT_TRUE(reliable.on_heartbeat(heartbeat(1, 8, 11), true, KeyAge::newest));
  EXPECT_THAT(missing(reliable, 8), ElementsAre(6, 7, 8));
}

TEST_F(NewestKeysTest, LaterRevision_BeginsAnew) {
  reliable.note_revised(), best_effort.note_revised();
  reliable.distrust_former_keys(), best_effort.distrust_former_keys();
  EXPECT_EQ(best_effort.next(), SequenceNumber{1});
  EXPECT_TRUE(reliable.on_heartbeat(heartbeat(1, 5, 2), true, KeyAge::newest));
  EXPECT_EQ(reliable.next(), SequenceNumber{6});
}

}  // namespace
}  // namespace ddssec::rtps
