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

// Readers that share the limits of what they hold: a participant writes to each of them.
struct SharedLimits : ::testing::Test {
  static constexpr std::uint32_t kMax = 1 << 20;  ///< octets that one identity may hold
  static constexpr std::uint16_t kFragment = 1024;

  struct Topic {
    std::vector<std::int64_t> delivered;
    StatefulReader reader;
    Topic(MessageSender& sender, const std::shared_ptr<HeldOctets>& held)
        : reader({kB, testing::kReader}, true, sender, [this](Change& change) {
            delivered.push_back(change.sequence_number.value);
            return true;
          }) {
      reader.share_held(held);
      reader.match({{kA, testing::kWriter}, true, {kHere}}, {});
    }
    void send(std::int64_t sample, std::uint32_t fragment, std::uint32_t size) {
      reader.on_data_frag(
          kA, {{}, testing::kWriter, {sample}, {fragment}, 1, kFragment, size, {}, false, octets},
          {}, false, KeyAge::newest);
    }
    // Sends all fragments of a sample.
    void send(std::int64_t sample, std::uint32_t size) {
      for (std::uint32_t i = 1; i <= size / kFragment; ++i) send(sample, i, size);
    }
    const Bytes octets = Bytes(kFragment);
  };

  Network net;
  MessageSender sender{net.b, kB};
  const std::shared_ptr<HeldOctets> held = std::make_shared<HeldOctets>();
  SharedLimits() { held->limit({.all = 2 * kMax, .of_one = kMax}); }
};

// An attacker that can forge messages on an open topic must not keep the samples of a protected
// topic from arriving.
TEST_F(SharedLimits, ClaimsOnOneTopic_LeaveRoomOnAnother) {
  Topic open(sender, held), secret(sender, held);
  constexpr std::uint32_t kClaimed = kMax / 2 - 2 * kFragment;
  open.send(1'000'000, 1, kClaimed);
  open.send(1'000'001, 1, kClaimed);
  secret.send(1, 4 * kFragment);
  EXPECT_THAT(secret.delivered, ElementsAre(1));
  // The same again, as long as the sample arrives.
  for (std::uint32_t i = 1; i <= 16; ++i) {
    secret.send(2, i, 16 * kFragment);
    open.send(1'000'001 + i, 1, kClaimed);
  }
  EXPECT_THAT(secret.delivered, ElementsAre(1, 2));
  EXPECT_LE(held->octets(), kMax);
}

// Claims that are spread over many writers or topics keep out only samples that are larger than
// what each of these topics holds.
TEST_F(SharedLimits, ClaimsOnManyTopics_LeaveAShareToEach) {
  std::vector<std::unique_ptr<Topic>> open;
  for (int i = 0; i < 7; ++i) open.push_back(std::make_unique<Topic>(sender, held));
  Topic secret(sender, held);
  for (auto& topic : open)
    for (std::int64_t number = 1'000'000; number < 1'000'004; ++number)
      topic->send(number, 1, kMax / 28 - 1024);
  secret.send(1, 100 * kFragment);
  EXPECT_THAT(secret.delivered, ElementsAre(1));
}

// Several large samples of an honest writer at once, on two topics. What is given up is requested
// again.
TEST_F(SharedLimits, LargeSamplesOfOneWriter_AllArrive) {
  Topic maps(sender, held), images(sender, held);
  constexpr std::uint32_t kLarge = kMax / 5 * 2 / kFragment * kFragment;
  for (std::uint32_t i = 1; i <= kLarge / kFragment; ++i) {
    maps.send(1, i, kLarge);
    maps.send(2, i, kLarge);
    images.send(1, i, kLarge);
  }
  EXPECT_THAT(maps.delivered, ElementsAre(1));
  EXPECT_THAT(images.delivered, ElementsAre(1));
  maps.send(2, kLarge);
  EXPECT_THAT(maps.delivered, ElementsAre(1, 2));
  EXPECT_EQ(held->octets(), 0u);
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
