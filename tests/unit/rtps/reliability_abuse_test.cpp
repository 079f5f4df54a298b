// How a writer and a reader treat messages of strangers, recorded messages, and samples that never
// complete.
#include <gmock/gmock.h>

#include "tests/unit/rtps/reliability_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace of_reliability;
using ::testing::ElementsAre;

TEST(Reliability, Strangers_AreNotHeard) {
  Pair pair(keep_all());
  pair.match();
  pair.run(5);
  pair.write({1});
  const auto stranger = GuidPrefix::from(Bytes(12, 0xcc));
  pair.reader.on_gap(stranger, Gap{{}, testing::kWriter, {1}, SequenceNumberSet({100})},
                     KeyAge::newest);
  pair.reader.on_heartbeat(stranger, Heartbeat{{}, testing::kWriter, {50}, {60}, 999}, true,
                           KeyAge::newest);
  pair.writer.on_acknack(stranger, AckNack{testing::kReader, {}, SequenceNumberSet({2}), 99, true},
                         pair.now, true, KeyAge::newest);
  EXPECT_FALSE(pair.writer.all_acknowledged());
  pair.run(10);
  EXPECT_THAT(pair.numbers(), ElementsAre(1));
}

TEST(Reliability, AnAcknackForMoreThanWasWritten_IsNotBelieved) {
  Pair pair(keep_all());
  pair.match();
  pair.net.loss_percent = 100;
  pair.write({1});
  pair.writer.on_acknack(kB, AckNack{testing::kReader, {}, SequenceNumberSet({1000}), 50, true},
                         pair.now, true, KeyAge::newest);
  EXPECT_EQ(pair.writer.history().size(), 1u);
}

// A pre-emptive ACKNACK (base 0 of Fast DDS, count 0 of Cyclone DDS) is answered, and changes
// nothing.
TEST(Reliability, APreEmptiveAcknack_DoesNotMakeRecordedOnesNew) {
  Pair pair(keep_all());
  pair.match();
  for (int i = 0; i < 6; ++i) pair.write(Bytes(700));
  pair.net.a.sent.clear();
  SequenceNumberSet all({1});
  for (std::int64_t number = 1; number <= 6; ++number) all.insert({number});
  const AckNack request{testing::kReader, testing::kWriter, all, 50, true};
  pair.writer.on_acknack(kB, request, pair.now, true, KeyAge::newest);
  const auto answered = std::exchange(pair.net.a.sent, {}).size();
  EXPECT_GE(answered, 1u);
  for (const auto& pre_emptive :
       {AckNack{testing::kReader, testing::kWriter, SequenceNumberSet({0}), 1, true},
        AckNack{testing::kReader, testing::kWriter, SequenceNumberSet({1}), 0, true}}) {
    pair.now += milliseconds(100);
    pair.writer.on_acknack(kB, pre_emptive, pair.now, true, KeyAge::newest);
    EXPECT_EQ(std::exchange(pair.net.a.sent, {}).size(), 1u) << "a heartbeat";
    for (std::int32_t count = 45; count <= 50; ++count) {
      pair.now += milliseconds(100);
      auto recorded = request;
      recorded.count = count;
      pair.writer.on_acknack(kB, recorded, pair.now, true, KeyAge::newest);
    }
    EXPECT_TRUE(pair.net.a.sent.empty());
  }
}

// Without protection anyone can send a count that no honest message reaches.
TEST(Reliability, ForgedCounts_DoNotEndTheRepairOfSamples) {
  constexpr std::int32_t kFarAhead = 0x40000000;
  Pair pair(keep_all());
  pair.is_protected = false;
  pair.match();
  pair.run(5);
  pair.reader.on_heartbeat(kA, {{}, testing::kWriter, {1}, {0}, kFarAhead, true}, false,
                           KeyAge::newest);
  pair.writer.on_acknack(
      kB, {testing::kReader, testing::kWriter, SequenceNumberSet({1}), kFarAhead, true}, pair.now,
      false, KeyAge::newest);
  FragmentNumberSet fragments({1});
  fragments.insert({1});
  pair.writer.on_nack_frag(kB, {testing::kReader, testing::kWriter, {1}, fragments, kFarAhead},
                           pair.now, false, KeyAge::newest);
  pair.net.loss_percent = 50;
  for (int i = 0; i < 10; ++i) pair.write(Bytes(i % 2 == 0 ? 100 : 5000));
  pair.run(1000);
  EXPECT_THAT(pair.numbers(), ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 9, 10));
  EXPECT_TRUE(pair.writer.all_acknowledged());
}

// No reader lacks the sample yet. A GAP for it would make the reader skip it later.
TEST(Reliability, ARequestForFragmentsOfALaterSample_MakesItNotIrrelevant) {
  Pair pair(keep_all());
  pair.match();
  pair.run(5);
  FragmentNumberSet fragments({1});
  fragments.insert({1});
  pair.writer.on_nack_frag(kB, {testing::kReader, testing::kWriter, {1}, fragments, 7}, pair.now,
                           true, KeyAge::newest);
  pair.run(5);
  pair.write({1});
  pair.run(5);
  EXPECT_THAT(pair.numbers(), ElementsAre(1));
}

// With two paths, each message arrives twice, in some order.
TEST(Reliability, UnprotectedRepetitions_AreNotAnsweredAgain) {
  Pair pair(keep_all());
  pair.is_protected = false;
  pair.match();
  pair.run(5);
  const Heartbeat question{{}, testing::kWriter, {1}, {0}, 1000};
  auto next = question;
  ++next.count;
  pair.net.b.sent.clear();
  for (int path = 0; path < 2; ++path)
    for (const auto& one : {question, next})
      pair.reader.on_heartbeat(kA, one, false, KeyAge::newest);
  EXPECT_EQ(pair.net.b.sent.size(), 2u);
}

// Only a new message is a sign of life.
TEST(Reliability, WhatIsRepeated_IsNotNew) {
  for (const bool reliable : {true, false}) {
    Pair pair(keep_all(), reliable);
    pair.match(false, reliable);
    auto& reader = pair.reader;
    const auto data = [](std::int64_t number) {
      return Data{{}, testing::kWriter, {number}, {}, PayloadKind::data, {}};
    };
    const Bytes half(1000);
    const auto fragment = [&](std::int64_t number, std::uint32_t first) {
      return DataFrag{{}, testing::kWriter, {number}, {first}, 1, 1000, 2000, {}, false, half};
    };
    const auto heartbeat = [](std::int32_t count) {
      return Heartbeat{{}, testing::kWriter, {1}, {3}, count, true, true};
    };
    EXPECT_TRUE(reader.on_data(kA, data(1), {}, {}, KeyAge::newest));
    EXPECT_FALSE(reader.on_data(kA, data(1), {}, {}, KeyAge::newest));
    EXPECT_TRUE(reader.on_data_frag(kA, fragment(2, 1), {}, false, KeyAge::newest));
    EXPECT_FALSE(reader.on_data_frag(kA, fragment(2, 1), {}, false, KeyAge::newest));
    EXPECT_TRUE(reader.on_data_frag(kA, fragment(2, 2), {}, false, KeyAge::newest));
    EXPECT_FALSE(reader.on_data_frag(kA, fragment(2, 2), {}, false, KeyAge::newest));
    EXPECT_TRUE(reader.on_data(kA, data(4), {}, {}, KeyAge::newest));
    EXPECT_FALSE(reader.on_data(kA, data(4), {}, {}, KeyAge::newest));
    EXPECT_TRUE(reader.on_heartbeat(kA, heartbeat(7), true, KeyAge::newest));
    EXPECT_FALSE(reader.on_heartbeat(kA, heartbeat(7), true, KeyAge::newest));
    EXPECT_FALSE(reader.on_heartbeat(kA, heartbeat(6), true, KeyAge::newest));
    EXPECT_TRUE(reader.on_heartbeat(kA, heartbeat(8), true, KeyAge::newest));
    EXPECT_FALSE(
        reader.on_gap(kA, Gap{{}, testing::kWriter, {1}, SequenceNumberSet({2})}, KeyAge::newest));
    const AckNack acknack{testing::kReader, testing::kWriter, SequenceNumberSet({1}), 5, true};
    EXPECT_EQ(pair.writer.on_acknack(kB, acknack, pair.now, true, KeyAge::newest), reliable);
    EXPECT_FALSE(pair.writer.on_acknack(kB, acknack, pair.now, true, KeyAge::newest));
  }
}

// 1100 writers of another identity that come and go do not make recorded samples new again.
TEST(Reliability, ReadersThatComeAndGo_DoNotMakeOthersForgotten) {
  Pair pair(keep_all());
  auto& reader = pair.reader;
  const MatchedWriter honest{pair.writer.guid(), true, {kHere}, false, Sha256Digest{1}, kA};
  const auto sample = [](std::int64_t number) {
    return Data{{}, testing::kWriter, {number}, {}, PayloadKind::data, {}};
  };
  reader.match(honest, pair.now);
  EXPECT_TRUE(reader.on_data(kA, sample(1), {}, {}, KeyAge::newest));
  reader.unmatch(honest.guid, honest.keys);
  for (std::uint32_t i = 0; i < 1100; ++i) {
    const Guid guid{kB, {{1, static_cast<std::uint8_t>(i >> 8), static_cast<std::uint8_t>(i), 2}}};
    reader.match({guid, true, {kHere}, false, Sha256Digest{2}, kB}, pair.now);
    reader.unmatch(guid, Sha256Digest{2});
  }
  reader.match(honest, pair.now);
  EXPECT_FALSE(reader.on_data(kA, sample(1), {}, {}, KeyAge::newest));
  EXPECT_TRUE(reader.on_data(kA, sample(2), {}, {}, KeyAge::newest));
}

// The reader gets a million early numbers, a GAP over 2^61 numbers ahead, and fragments of samples
// that never complete.
TEST(Reliability, WhatNeverCompletes_StaysBounded) {
  Pair pair(keep_all());
  pair.match();
  for (std::int64_t i = 2; i < 100'000; ++i)
    pair.reader.on_data(kA, Data{{}, testing::kWriter, {i}, {}, PayloadKind::data, Bytes{1}}, {},
                        {}, KeyAge::newest);
  pair.reader.on_gap(kA, Gap{{}, testing::kWriter, {5}, SequenceNumberSet({1ll << 61})},
                     KeyAge::newest);
  EXPECT_TRUE(pair.delivered.empty());
  pair.reader.on_data(kA, Data{{}, testing::kWriter, {1}, {}, PayloadKind::data, Bytes{1}}, {}, {},
                      KeyAge::newest);
  EXPECT_EQ(pair.delivered.size(), 1 + WriterProxy::kMaxEarlyChanges);
  const Bytes part(1000);
  for (std::int64_t i = 1; i < 1000; ++i) {
    DataFrag frag{{}, testing::kWriter, {200'000 + i}, {1}, 1, 1000, 64u << 20, {}, false, part};
    pair.reader.on_data_frag(kA, frag, {}, false, KeyAge::newest);
  }
  DataFrag too_large{{}, testing::kWriter, {3000}, {1}, 1, 1000, (64u << 20) + 1, {}, false, part};
  pair.reader.on_data_frag(kA, too_large, {}, false, KeyAge::newest);
  EXPECT_EQ(pair.delivered.size(), 1 + WriterProxy::kMaxEarlyChanges);
}

TEST(Reliability, ASampleBeyondTheLargest_IsGivenUpNotAskedForAgain) {
  Pair pair(keep_all());
  pair.match();
  const Bytes part(1000);
  DataFrag frag{{}, testing::kWriter, {1}, {1}, 1, 1000, (64u << 20) + 1, {}, false, part};
  pair.reader.on_data_frag(kA, frag, {}, false, KeyAge::newest);
  pair.reader.on_data(kA, Data{{}, testing::kWriter, {2}, {}, PayloadKind::data, Bytes{1}}, {}, {},
                      KeyAge::newest);
  EXPECT_THAT(pair.numbers(), ElementsAre(2));
}

TEST(Reliability, ASampleBeyondTheLargest_IsReportedOnce) {
  Pair pair(keep_all());
  std::vector<std::uint32_t> dropped;
  pair.reader.on_dropped([&](const Guid& writer, std::uint32_t octets) {
    EXPECT_EQ(writer, pair.writer.guid());
    dropped.push_back(octets);
  });
  pair.match();
  const Bytes part(1000);
  for (const std::uint32_t excess : {0u, 1u, 1u}) {
    const auto number = SequenceNumber{1 + std::int64_t{excess}};
    DataFrag frag{{},   testing::kWriter,     number, {1},   1,
                  1000, (64u << 20) + excess, {},     false, part};
    pair.reader.on_data_frag(kA, frag, {}, false, KeyAge::newest);
  }
  EXPECT_THAT(dropped, ElementsAre((64u << 20) + 1));
}

std::size_t octets_to_a_best_effort_reader(Pair& pair, std::uint8_t number) {
  pair.writer.match({{kB, EntityId{{0, 0, number, 4}}}, false, true, {kHere}}, pair.now);
  std::size_t octets = 0;
  for (const auto& message : std::exchange(pair.net.a.sent, {})) octets += message.size();
  return octets;
}

Qos durable() {
  auto qos = keep_all();
  qos.durability = DurabilityKind::transient_local;
  return qos;
}

// An insider announces readers at any address, and requests nothing. Without a common allowance,
// each of them would be sent the whole history at once.
TEST(BestEffortReaders, ManyReaders_ShareTheHistoryThatTheyGet) {
  constexpr std::size_t kSamples = 2 * HistoryAllowance::kMaxOctets / 32'000;
  Pair pair(durable());
  for (std::size_t i = 0; i < kSamples; ++i) pair.write(Bytes(32'000, 1));
  std::size_t octets = 0;
  for (std::uint8_t number = 1; number <= 40; ++number)
    octets += octets_to_a_best_effort_reader(pair, number);
  EXPECT_GT(octets, HistoryAllowance::kMaxOctets * 9 / 10);
  EXPECT_LT(octets, HistoryAllowance::kMaxOctets * 11 / 10);
  EXPECT_LT(octets_to_a_best_effort_reader(pair, 41), 32'000u);
  pair.now += std::chrono::seconds(1);
  EXPECT_GT(octets_to_a_best_effort_reader(pair, 42), 900'000u);
}

TEST(BestEffortReaders, LongHistory_IsCutToItsLatestInOrder) {
  Pair pair(durable(), false);
  constexpr std::size_t kSize = HistoryAllowance::kMaxOctets / 4;
  for (std::uint8_t i = 1; i <= 6; ++i) pair.write(Bytes(kSize, i));
  pair.match(true, false);
  pair.run(1);
  EXPECT_THAT(pair.numbers(), ElementsAre(4, 5, 6));
}

}  // namespace
}  // namespace ddssec::rtps
