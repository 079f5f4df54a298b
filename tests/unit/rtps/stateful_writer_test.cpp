// Changes that a writer keeps, refuses and sends again.
#include "rtps/reliability/stateful_writer.hpp"

#include <gmock/gmock.h>

#include "tests/unit/rtps/reliability_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace of_reliability;
using ::testing::ElementsAre;

TEST(Reliability, ALateJoinerOfAVolatileWriter_GetsOnlyWhatIsNew) {
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

TEST(Reliability, ALateJoinerOfATransientLocalWriter_GetsItsHistory) {
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

TEST(Reliability, KeepLast_ReplacesUnacknowledgedChangesAndGapsThem) {
  Pair pair;  // the depth is 1
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

TEST(Reliability, KeepAll_RefusesWhenItsLimitIsReached) {
  auto qos = keep_all();
  qos.resource_limits.max_samples = 3;
  Pair pair(qos);
  pair.match();
  pair.run(3);
  pair.net.loss_percent = 100;
  for (std::uint8_t i = 0; i < 3; ++i) {
    EXPECT_TRUE(pair.writer.history().has_room(1));
    pair.write({i});
  }
  EXPECT_FALSE(pair.writer.history().has_room(1));
  pair.net.loss_percent = 0;
  pair.run(50);
  EXPECT_TRUE(pair.writer.history().has_room(1));
}

TEST(Reliability, KeepAll_RefusesWhenAnInstanceIsFull) {
  auto qos = keep_all();
  qos.resource_limits.max_samples_per_instance = 2;
  Pair pair(qos);
  pair.match();
  pair.run(3);
  pair.net.loss_percent = 100;
  const KeyHash one{1}, other{2};
  for (std::uint8_t i = 0; i < 2; ++i) pair.write({i}, one);
  EXPECT_FALSE(pair.writer.history().has_room(1, one));
  EXPECT_TRUE(pair.writer.history().has_room(1, other));
  pair.net.loss_percent = 0;
  pair.run(50);
  EXPECT_TRUE(pair.writer.history().has_room(1, one));
}

TEST(Reliability, WhatIsDiscarded_IsNeverSentAgain) {
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

// The form in which a key is sent depends on the matched readers, but the held form does not.
TEST(Reliability, AKey_GoesOutAsAllMatchedReadersReadIt) {
  Pair pair(keep_all());
  pair.writer.rewrite_keys_with([](BytesView) { return Bytes{0, 9, 0, 0, 'b', 'a', 'r', 'e'}; });
  pair.match();
  const Bytes delimited = {0, 9, 0, 0, 4, 0, 0, 0, 'b', 'a', 'r', 'e'};
  const auto dispose = [&] {
    Change change;
    change.status.disposed = true;
    change.is_key_only = true;
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

TEST(Reliability, AWriter_KnowsWhenItIsAhead) {
  Pair pair(keep_all());
  pair.match();
  pair.run(3);
  for (int i = 0; i < 60; ++i) pair.write(Bytes(10'000));
  EXPECT_TRUE(pair.writer.is_ahead(pair.now));
  pair.run(20);
  EXPECT_FALSE(pair.writer.is_ahead(pair.now));
}

}  // namespace
}  // namespace ddssec::rtps
