// One writer and one reader over a network that loses, duplicates and reorders messages.
#include <set>
#include <utility>

#include <gmock/gmock.h>

#include "tests/unit/rtps/reliability_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace of_reliability;
using ::testing::ElementsAre;

TEST(Reliability, Samples_AreDeliveredInOrderAndForgottenOnceAcknowledged) {
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

TEST(Reliability, LossDuplicationAndReordering_LoseNothing) {
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

TEST(Reliability, LargeSamples_ComeInFragmentsAndAreRepairedSelectively) {
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

// The fragments of a message.
std::set<std::pair<std::int64_t, std::uint32_t>> fragments_in(const Bytes& message) {
  std::set<std::pair<std::int64_t, std::uint32_t>> out;
  auto walker = *MessageReader::open(message);
  for (auto next = walker.next(); next && *next; next = walker.next()) {
    if ((**next).id != SubmessageId::data_frag) continue;
    const auto data = *read_data_frag(**next);
    for (std::uint32_t i = 0; i < data.count; ++i)
      out.emplace(data.sequence_number.value, data.first.value + i);
  }
  return out;
}

TEST(Reliability, LargeSamplesWithLittleLoss_NothingThatArrivedIsSentAgain) {
  for (const std::size_t size : {std::size_t{1} << 20, std::size_t{5'000'000}}) {
    std::size_t all = 0, lost = 0;
    for (unsigned seed = 1; seed <= 10; ++seed) {
      Pair pair(keep_all());
      pair.match();
      pair.run(5);
      pair.net.random.seed(seed);
      pair.net.loss_percent = 1;
      pair.write(Bytes(size, 7));
      std::set<std::pair<std::int64_t, std::uint32_t>> sent, arrived;
      for (int i = 0; i < 300; ++i) {
        for (const auto& message : pair.net.a.sent)
          for (const auto& fragment : fragments_in(message)) {
            EXPECT_FALSE(arrived.contains(fragment)) << fragment.second << ", seed " << seed;
            lost += sent.insert(fragment).second ? 0 : 1;
          }
        pair.net.carry(pair.net.a, [&](const Bytes& message) {
          arrived.merge(fragments_in(message));
          pair.receive(message);
        });
        pair.net.carry(pair.net.b, [&](const Bytes& message) { pair.receive(message); });
        pair.now += milliseconds(10);
        pair.writer.tick(pair.now);
        pair.reader.tick(pair.now);
      }
      ASSERT_THAT(pair.numbers(), ElementsAre(1)) << size << ", seed " << seed;
      EXPECT_EQ(pair.delivered[0].payload.size(), size);
      EXPECT_EQ(arrived, sent);
      all += sent.size();
    }
    EXPECT_GT(lost, 0u) << "control: some were lost";
    EXPECT_LT(lost, all / 20);
  }
}

// Cyclone DDS requests 256 fragments, and then nothing for 100 ms.
TEST(Reliability, OneRequest_IsAnsweredInPortionsWithoutAnother) {
  Pair pair(keep_all());
  pair.match();
  pair.run(3);
  pair.write(Bytes(1'000'000));
  pair.net.a.sent.clear();
  FragmentNumberSet all(FragmentNumber{1});
  for (std::uint32_t i = 1; i <= 70; ++i) all.insert({i});
  pair.writer.on_nack_frag(kB, {testing::kReader, testing::kWriter, {1}, all, 1}, pair.now, true,
                           KeyAge::newest);
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

TEST(Reliability, RepairOfSeveralLargeSamples_StaysInProportion) {
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

}  // namespace
}  // namespace ddssec::rtps
