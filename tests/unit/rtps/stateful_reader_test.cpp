// How a reader uses its room, and treats losses and unfinished samples.
#include "rtps/reliability/stateful_reader.hpp"

#include <gmock/gmock.h>

#include "tests/unit/rtps/reliability_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace of_reliability;
using ::testing::ElementsAre;

TEST(Reliability, AFullReader_IsAWriterThatWaits) {
  auto qos = keep_all();
  qos.resource_limits.max_samples = 5;
  Pair pair(qos);
  pair.most = 3;
  pair.match();
  pair.run(3);
  for (std::uint8_t i = 0; i < 5; ++i) pair.write({i});
  pair.run(50);
  EXPECT_THAT(pair.numbers(), ElementsAre(1, 2, 3));
  EXPECT_TRUE(pair.writer.history().has_room(1));
  EXPECT_FALSE(pair.writer.all_acknowledged());
  pair.most = 100;
  pair.run(500);
  EXPECT_THAT(pair.numbers(), ElementsAre(1, 2, 3, 4, 5));
  EXPECT_TRUE(pair.writer.all_acknowledged());
}

TEST(Reliability, BestEffort_NeitherAsksNorGoesBack) {
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

TEST(Reliability, RoomInAFullReader_IsUsedAtOnce) {
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

TEST(Reliability, BestEffort_LosesWhatItMissesAfterItsFirstSample) {
  auto qos = default_writer_qos();
  qos.reliability.kind = ReliabilityKind::best_effort;
  Pair pair(qos, false);
  std::int64_t lost = 0;
  pair.reader.on_lost([&](std::int64_t count) { lost += count; });
  for (std::uint8_t i = 0; i < 5; ++i) pair.write({i});
  pair.match(false, false);
  pair.write({1});
  pair.run(1);
  EXPECT_EQ(lost, 0);  // samples that were written before it came do not count
  pair.net.loss_percent = 100;
  for (std::uint8_t i = 0; i < 3; ++i) pair.write({i});
  pair.run(1);
  pair.net.loss_percent = 0;
  pair.write({1});
  pair.run(1);
  EXPECT_EQ(lost, 3);
}

TEST(Reliability, Reliable_LosesWhatItsWriterNoLongerHas) {
  Pair pair;
  std::int64_t lost = 0;
  pair.reader.on_lost([&](std::int64_t count) { lost += count; });
  const auto says = [&](std::int64_t first, std::int64_t last, std::int32_t count) {
    pair.reader.on_heartbeat(kA, {testing::kReader, testing::kWriter, {first}, {last}, count}, true,
                             KeyAge::newest);
  };
  pair.match();
  says(10, 12, 100);
  EXPECT_EQ(lost, 0);
  says(13, 15, 101);
  EXPECT_EQ(lost, 3);
  pair.reader.on_gap(kA, {testing::kReader, testing::kWriter, {13}, SequenceNumberSet({16})},
                     KeyAge::newest);
  EXPECT_EQ(lost, 3);
}

// This is a reader of a keeper: a sample that it has taken is acknowledged once it is stored.
TEST(Reliability, WhatIsUnfinished_IsNotAcknowledged) {
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

// Some messages are lost. Missing samples are requested although earlier ones are not acknowledged.
TEST(Reliability, WhatIsUnfinished_HidesNoLoss) {
  Pair pair(keep_all());
  pair.reader.acknowledge_before([](const Guid&, SequenceNumber) { return SequenceNumber{1}; });
  pair.net.loss_percent = 30;
  pair.match();
  for (int i = 0; i < 100; ++i) pair.write(Bytes{1});
  pair.run(400);
  EXPECT_EQ(pair.delivered.size(), 100u);
  EXPECT_EQ(pair.writer.history().first(), SequenceNumber{1});
}

TEST(Reliability, AGapAtTheFront_IsSkippedAsAWhole) {
  Pair pair(keep_all());
  pair.match();
  pair.reader.on_gap(kA, Gap{{}, testing::kWriter, {1}, SequenceNumberSet({1ll << 61})},
                     KeyAge::newest);
  pair.reader.on_data(kA, Data{{}, testing::kWriter, {1ll << 61}, {}, PayloadKind::data, Bytes{1}},
                      {}, {}, KeyAge::newest);
  EXPECT_EQ(pair.delivered.size(), 1u);
}

}  // namespace
}  // namespace ddssec::rtps
