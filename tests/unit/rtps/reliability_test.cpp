// One writer and one reader over a network that loses, doubles and reorders.
#include <gmock/gmock.h>

#include "tests/unit/rtps/reliability_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace of_reliability;
using ::testing::ElementsAre;

TEST(Reliability, DeliversInOrderAndForgetsWhatIsAcknowledged) {
  Pair pair(keep_all());
  pair.match();
  pair.run(3);
  for (std::uint8_t i = 0; i < 3; ++i) pair.write({0, 1, 0, 0, i, 0, 0, 0});
  pair.run(20);
  EXPECT_THAT(pair.numbers(), ElementsAre(1, 2, 3));
  EXPECT_EQ(to_bytes(pair.delivered[2].payload.view()), (Bytes{0, 1, 0, 0, 2, 0, 0, 0}));
  EXPECT_TRUE(pair.writer.all_acknowledged());
  EXPECT_EQ(pair.writer.history().size(), 0u);
  EXPECT_EQ(pair.writer.next_tick(), kNever);
  const auto before = pair.net.messages;
  pair.run(100);
  EXPECT_EQ(pair.net.messages, before) << "an idle pair is silent";
}

TEST(Reliability, LossDuplicationAndReorderingLoseNothing) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    Pair pair(keep_all());
    pair.net.random.seed(seed);
    pair.net.loss_percent = 30, pair.net.duplicate_percent = 10, pair.net.reorder = true;
    pair.match();
    std::vector<std::int64_t> expected;
    for (int i = 1; i <= 1000; ++i) {
      pair.write({0, 1, 0, 0, static_cast<std::uint8_t>(i)});
      expected.push_back(i);
      if (i % 50 == 0) pair.run(1);
    }
    pair.run(3000);
    EXPECT_EQ(pair.numbers(), expected) << seed;
    EXPECT_TRUE(pair.writer.all_acknowledged());
  }
}

TEST(Reliability, LargeSamplesComeInFragmentsAndAreRepairedSelectively) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    Pair pair(keep_all());
    pair.net.random.seed(seed);
    pair.net.loss_percent = 20, pair.net.reorder = true;
    pair.match();
    pair.run(5);
    Bytes large(3'000'000);
    for (std::size_t i = 0; i < large.size(); ++i)
      large[i] = static_cast<std::uint8_t>(i * 7 + i / 256);
    pair.net.messages = 0;
    pair.write(large);
    pair.write({0, 1, 0, 0});
    pair.run(500);
    ASSERT_THAT(pair.numbers(), ElementsAre(1, 2));
    EXPECT_EQ(to_bytes(pair.delivered[0].payload.view()), large);
    EXPECT_LT(pair.net.messages, 2 * 210u) << "only what was lost is sent again";
  }
}

// Cyclone DDS asks for 256 fragments and then not again for 100 ms.
TEST(Reliability, OneRequestIsAnsweredInPortionsWithoutAnother) {
  Pair pair(keep_all());
  pair.match();
  pair.run(3);
  pair.write(Bytes(1'000'000));
  pair.net.a.sent.clear();
  FragmentNumberSet all(FragmentNumber{1});
  for (std::uint32_t i = 1; i <= 70; ++i) all.insert({i});
  pair.writer.on_nack_frag(kB, {testing::kReader, testing::kWriter, {1}, all, 1}, pair.now);
  std::size_t most = 0;
  for (int i = 0; i < 12; ++i) {
    most = std::max(most, pair.net.a.sent.size());
    pair.net.carry(pair.net.a, [&](const Bytes& message) { pair.receive(message); });
    pair.net.b.sent.clear();
    pair.now += milliseconds(1);
    pair.writer.tick(pair.now);
  }
  EXPECT_EQ(pair.delivered.size(), 1u);
  EXPECT_LE(most, 10u) << "a portion at a time";
}

TEST(Reliability, RepairOfSeveralLargeSamplesStaysInProportion) {
  Pair pair(keep_all());
  pair.match();
  pair.run(3);
  pair.net.messages = 0;
  pair.net.loss_percent = 30;
  for (int i = 0; i < 4; ++i) pair.write(Bytes(1'000'000));
  pair.run(1000);
  ASSERT_THAT(pair.numbers(), ElementsAre(1, 2, 3, 4));
  EXPECT_LT(pair.net.messages, 2 * 4 * 70u);
}

TEST(Reliability, ALateJoinerOfAVolatileWriterGetsOnlyWhatIsNew) {
  Pair pair(keep_all());
  for (int i = 0; i < 5; ++i) pair.write({1});
  EXPECT_EQ(pair.writer.history().size(), 0u);
  pair.match(true);
  pair.run(5);
  pair.write({2});
  pair.run(20);
  EXPECT_THAT(pair.numbers(), ElementsAre(6));
  EXPECT_TRUE(pair.writer.all_acknowledged());
}

TEST(Reliability, ALateJoinerOfATransientLocalWriterGetsItsHistory) {
  auto qos = default_writer_qos();
  qos.durability = DurabilityKind::transient_local;
  qos.history.depth = 2;
  Pair pair(qos);
  for (std::uint8_t key = 0; key < 2; ++key)
    for (std::uint8_t i = 0; i < 4; ++i) pair.write({i}, KeyHash{key});
  EXPECT_EQ(pair.writer.history().size(), 4u);
  pair.match(true);
  pair.run(20);
  EXPECT_THAT(pair.numbers(), ElementsAre(3, 4, 7, 8));
  EXPECT_TRUE(pair.writer.all_acknowledged());
}

TEST(Reliability, KeepLastReplacesUnacknowledgedChangesAndGapsThem) {
  Pair pair;  // depth 1
  pair.match();
  pair.run(3);
  pair.net.loss_percent = 100;
  for (std::uint8_t i = 1; i <= 10; ++i) pair.write({i});
  pair.run(5);
  pair.net.loss_percent = 0;
  pair.run(50);
  EXPECT_THAT(pair.numbers(), ElementsAre(10));
  EXPECT_TRUE(pair.writer.all_acknowledged());
}

TEST(Reliability, KeepAllRefusesWhenItsLimitIsReached) {
  auto qos = keep_all();
  qos.resource_limits.max_samples = 3;
  Pair pair(qos);
  pair.match();
  pair.run(3);
  pair.net.loss_percent = 100;
  for (std::uint8_t i = 0; i < 3; ++i) {
    EXPECT_TRUE(pair.writer.has_room(1));
    pair.write({i});
  }
  EXPECT_FALSE(pair.writer.has_room(1));
  pair.net.loss_percent = 0;
  pair.run(50);
  EXPECT_TRUE(pair.writer.has_room(1));
}

TEST(Reliability, AFullReaderIsAWriterThatWaits) {
  auto qos = keep_all();
  qos.resource_limits.max_samples = 5;
  Pair pair(qos);
  pair.most = 3;
  pair.match();
  pair.run(3);
  for (std::uint8_t i = 0; i < 5; ++i) pair.write({i});
  pair.run(50);
  EXPECT_THAT(pair.numbers(), ElementsAre(1, 2, 3));
  EXPECT_TRUE(pair.writer.has_room(1));
  EXPECT_FALSE(pair.writer.all_acknowledged());
  pair.most = 100;
  pair.run(500);
  EXPECT_THAT(pair.numbers(), ElementsAre(1, 2, 3, 4, 5));
  EXPECT_TRUE(pair.writer.all_acknowledged());
}

TEST(Reliability, BestEffortNeitherAsksNorGoesBack) {
  auto qos = default_writer_qos();
  qos.reliability.kind = ReliabilityKind::best_effort;
  Pair pair(qos, false);
  pair.match(false, false);
  pair.net.loss_percent = 50, pair.net.reorder = true, pair.net.duplicate_percent = 50;
  for (int i = 0; i < 100; ++i) {
    pair.write({1});
    pair.run(1);
  }
  EXPECT_TRUE(std::ranges::is_sorted(pair.numbers(), std::less_equal{}));
  EXPECT_GT(pair.delivered.size(), 20u);
  EXPECT_TRUE(pair.net.b.sent.empty());
}

TEST(Reliability, RoomInAFullReaderIsUsedAtOnce) {
  Pair pair(keep_all());
  pair.most = 3;
  pair.match();
  pair.run(3);
  for (std::uint8_t i = 0; i < 5; ++i) pair.write({i});
  pair.run(3);
  EXPECT_THAT(pair.numbers(), ElementsAre(1, 2, 3));
  pair.most = 100;
  pair.reader.offer_again();
  EXPECT_THAT(pair.numbers(), ElementsAre(1, 2, 3, 4, 5));
  pair.run(1);
  EXPECT_TRUE(pair.writer.all_acknowledged());
}

TEST(Reliability, KeepAllRefusesWhenAnInstanceIsFull) {
  auto qos = keep_all();
  qos.resource_limits.max_samples_per_instance = 2;
  Pair pair(qos);
  pair.match();
  pair.run(3);
  pair.net.loss_percent = 100;
  const KeyHash one{1}, other{2};
  for (std::uint8_t i = 0; i < 2; ++i) pair.write({i}, one);
  EXPECT_FALSE(pair.writer.has_room(1, one));
  EXPECT_TRUE(pair.writer.has_room(1, other));
  pair.net.loss_percent = 0;
  pair.run(50);
  EXPECT_TRUE(pair.writer.has_room(1, one));
}

TEST(Reliability, WhatIsDiscardedIsNeverSentAgain) {
  auto qos = keep_all();
  qos.durability = DurabilityKind::transient_local;
  Pair pair(qos);
  for (std::uint8_t i = 0; i < 4; ++i) pair.write({i});
  pair.writer.discard({1});
  pair.writer.discard({3});
  pair.writer.discard({9});
  EXPECT_EQ(pair.writer.history().size(), 2u);
  pair.match(true);
  pair.run(10);
  EXPECT_THAT(pair.numbers(), ElementsAre(2, 4));
  EXPECT_TRUE(pair.writer.all_acknowledged());
}

TEST(Reliability, LostIsWhatABestEffortReaderMissesAfterItsFirstSample) {
  auto qos = default_writer_qos();
  qos.reliability.kind = ReliabilityKind::best_effort;
  Pair pair(qos, false);
  std::int64_t lost = 0;
  pair.reader.on_lost([&](std::int64_t count) { lost += count; });
  for (std::uint8_t i = 0; i < 5; ++i) pair.write({i});
  pair.match(false, false);
  pair.write({1});
  pair.run(1);
  EXPECT_EQ(lost, 0);  // what was written before it came
  pair.net.loss_percent = 100;
  for (std::uint8_t i = 0; i < 3; ++i) pair.write({i});
  pair.run(1);
  pair.net.loss_percent = 0;
  pair.write({1});
  pair.run(1);
  EXPECT_EQ(lost, 3);
}

TEST(Reliability, LostIsWhatAReliableWriterNoLongerHas) {
  Pair pair;
  std::int64_t lost = 0;
  pair.reader.on_lost([&](std::int64_t count) { lost += count; });
  const auto says = [&](std::int64_t first, std::int64_t last, std::int32_t count) {
    pair.reader.on_heartbeat(kA, {testing::kReader, testing::kWriter, {first}, {last}, count});
  };
  pair.match();
  says(10, 12, 100);
  EXPECT_EQ(lost, 0);
  says(13, 15, 101);
  EXPECT_EQ(lost, 3);
  pair.reader.on_gap(kA, {testing::kReader, testing::kWriter, {13}, SequenceNumberSet({16})});
  EXPECT_EQ(lost, 3);
}

// A keeper's: what it has taken is acknowledged when it is stored.
TEST(Reliability, WhatIsUnfinishedIsNotAcknowledged) {
  Pair pair(keep_all());
  SequenceNumber unfinished{3};
  pair.reader.acknowledge_before(
      [&](const Guid&, SequenceNumber next) { return std::min(next, unfinished); });
  pair.match();
  pair.run(3);
  for (int i = 0; i < 5; ++i) pair.write(Bytes{1});
  pair.run(300);
  EXPECT_THAT(pair.numbers(), ElementsAre(1, 2, 3, 4, 5));
  EXPECT_EQ(pair.writer.history().first(), SequenceNumber{3});
  EXPECT_FALSE(pair.writer.all_acknowledged());
  unfinished = {100};
  pair.reader.acknowledge_again({pair.writer.guid().prefix, EntityId{{0, 0, 99, 2}}});
  pair.run(1);
  EXPECT_FALSE(pair.writer.all_acknowledged()) << "another writer causes no ACKNACK";
  pair.reader.acknowledge_again(pair.writer.guid());
  pair.run(1);
  EXPECT_TRUE(pair.writer.all_acknowledged());
  EXPECT_THAT(pair.numbers(), ElementsAre(1, 2, 3, 4, 5));
}

// With losses: what is missing is asked for although what came before is not acknowledged.
TEST(Reliability, WhatIsUnfinishedHidesNoLoss) {
  Pair pair(keep_all());
  pair.reader.acknowledge_before([](const Guid&, SequenceNumber) { return SequenceNumber{1}; });
  pair.net.loss_percent = 30;
  pair.match();
  for (int i = 0; i < 100; ++i) pair.write(Bytes{1});
  pair.run(400);
  EXPECT_EQ(pair.delivered.size(), 100u);
  EXPECT_EQ(pair.writer.history().first(), SequenceNumber{1});
}

// What is sent depends on who reads; what is held does not.
TEST(Reliability, AKeyGoesOutAsAllMatchedReadersReadIt) {
  Pair pair(keep_all());
  pair.writer.rewrite_keys_with([](BytesView) { return Bytes{0, 9, 0, 0, 'b', 'a', 'r', 'e'}; });
  pair.match();
  const Bytes delimited = {0, 9, 0, 0, 4, 0, 0, 0, 'b', 'a', 'r', 'e'};
  const auto dispose = [&] {
    Change change;
    change.status.disposed = true;
    change.key_only = true;
    change.key_hash = KeyHash{};
    change.payload = Payload::copy_of(delimited);
    pair.writer.write(std::move(change), pair.now);
    pair.run(3);
    EXPECT_FALSE(pair.delivered.empty());
    return to_bytes(pair.delivered.back().payload.view());
  };
  EXPECT_EQ(dispose(), delimited);
  const Guid cyclone{GuidPrefix::from(Bytes(12, 0xcc)), testing::kReader};
  MatchedReader second{cyclone, true, false, {kHere}};
  second.keys.bare_only = true;
  pair.writer.match(std::move(second), pair.now);
  EXPECT_EQ(dispose(), (Bytes{0, 9, 0, 0, 'b', 'a', 'r', 'e'}));
  pair.writer.unmatch(cyclone);
  EXPECT_EQ(dispose(), delimited);
}

TEST(Reliability, AWriterKnowsWhenItIsAhead) {
  Pair pair(keep_all());
  pair.match();
  pair.run(3);
  for (int i = 0; i < 60; ++i) pair.write(Bytes(10'000));
  EXPECT_TRUE(pair.writer.is_ahead(pair.now));
  pair.run(20);
  EXPECT_FALSE(pair.writer.is_ahead(pair.now));
}

TEST(Reliability, AGapAtTheFrontIsSkippedAsAWhole) {
  Pair pair(keep_all());
  pair.match();
  pair.reader.on_gap(kA, Gap{{}, testing::kWriter, {1}, SequenceNumberSet({1ll << 61})});
  pair.reader.on_data(kA, Data{{}, testing::kWriter, {1ll << 61}, {}, PayloadKind::data, Bytes{1}},
                      {});
  EXPECT_EQ(pair.delivered.size(), 1u);
}

}  // namespace
}  // namespace ddssec::rtps
