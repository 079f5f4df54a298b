// How much a reader holds for each identity, and what its bookkeeping costs.
#include <ctime>

#include "tests/unit/rtps/reader_cache_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;
using ReaderCacheTest = Cache;

// Otherwise one identity could take all 65,536 instances, and no other writer would be heard.
TEST_F(ReaderCacheTest, OneIdentity_NeverTakesAllInstances) {
  const auto identity = [](std::uint8_t n) { return writer(n).prefix; };
  for (std::uint8_t i = 1; i <= 3; ++i)
    cache().set_writer(writer(i), 0, kDurationInfinite, identity(i == 2 ? 1 : i));
  const auto fill = [&](std::uint8_t from, std::uint32_t first, std::uint32_t count) {
    std::uint32_t stored = 0;
    for (auto i = first; i < first + count; ++i) {
      Change change;
      change.writer = writer(from);
      auto& key = change.key_hash.emplace();
      for (std::size_t at = 0; at < 4; ++at) key[at] = static_cast<std::uint8_t>(i >> (8 * at));
      stored += cache().store(change, moment()).outcome == StoreResult::stored ? 1 : 0;
      if (stored % 1000 == 0) take();
    }
    take();
    return stored;
  };
  constexpr auto kHalf = static_cast<std::uint32_t>(HeldInstances::kMaxInstances / 2);
  EXPECT_EQ(fill(1, 0, kHalf + 10), kHalf);
  EXPECT_EQ(fill(2, 500'000, 10), 0u) << "another participant of the same identity";
  EXPECT_EQ(fill(3, 1'000'000, kHalf), kHalf / 2);
  EXPECT_EQ(fill(3, 0, 10), 10u) << "instances that are there have room for anybody's samples";
  cache().lose_writer(writer(1), ReaderCache::WriterLoss::unmatched, now);
  take();
  EXPECT_EQ(fill(3, 2'000'000, 10), 10u) << "what has ended makes room";
}

constexpr std::size_t kLarge = std::size_t{16} << 20;
constexpr std::array<std::uint8_t, 2> kTwo = {1, 3};

struct Shares : Cache {
  Shares() {
    for (std::uint8_t i = 1; i <= 3; ++i)
      cache().set_writer(writer(i), 0, kDurationInfinite, writer(i == 2 ? 1 : i).prefix);
  }
  ReaderCache::StoreReport put_octets(std::uint8_t from, std::uint8_t key, std::size_t octets) {
    Change change;
    change.writer = writer(from);
    change.key_hash = KeyHash{key};
    change.payload = Payload::uninitialized(octets);
    return cache().store(change, moment());
  }
  // Returns how many samples are stored, each in an instance of its own.
  std::size_t fill(std::uint8_t from, std::size_t octets, std::size_t count) {
    std::size_t stored = 0;
    for (std::size_t i = 0; i < count; ++i, ++keys)
      stored += put_octets(from, keys, octets).outcome == StoreResult::stored ? 1 : 0;
    return stored;
  }
  std::uint8_t keys = 0;
};

// Otherwise one identity could take all octets, and the samples of others would be rejected for as
// long as its own stayed.
TEST_F(Shares, SamplesOfOneIdentity_HoldAtMostHalfOfTheOctets) {
  constexpr auto kHalf = HeldInstances::kMaxOctetsOfOne / kLarge;
  EXPECT_EQ(fill(1, kLarge, 20), kHalf);
  EXPECT_EQ(fill(2, kLarge, 2), 0u) << "another participant of the same identity";
  const auto refused = put_octets(1, keys, kLarge);
  EXPECT_EQ(refused.reason, Reason::by_samples_limit);
  EXPECT_TRUE(refused.crowded);
  EXPECT_EQ(fill(3, kLarge, 20), kHalf / 2);
  cache().lose_writer(writer(1), ReaderCache::WriterLoss::unmatched, now);
  cache().lose_writer(writer(2), ReaderCache::WriterLoss::unmatched, now);
  EXPECT_EQ(fill(3, kLarge, 2), 0u) << "the samples are still held";
  take();
  EXPECT_EQ(cache().held().octets(), 0u + cache().held().all().size()) << "nothing but keys";
  EXPECT_EQ(fill(3, kLarge, 20), kHalf) << "their room is free again";
}

TEST_F(Shares, FullShare_OwnSamplesGiveWay) {
  qos.history = {HistoryKind::keep_last, 1};
  made.reset();
  cache().set_writer(writer(1), 0, kDurationInfinite, writer(1).prefix);
  ASSERT_GT(fill(1, kLarge, 20), 0u);
  EXPECT_EQ(put_octets(1, 0, kLarge).outcome, StoreResult::stored);
  EXPECT_EQ(put_octets(1, 100, kLarge).outcome, StoreResult::rejected);
}

// A reader that takes all samples holds the keys as long as the instances are alive.
TEST_F(Shares, LargeKeysOfOneIdentity_HoldAtMostHalfOfTheOctets) {
  made.emplace(qos, [](const Change&) { return Bytes(kLarge); });
  for (const auto i : kTwo) cache().set_writer(writer(i), 0, kDurationInfinite, writer(i).prefix);
  std::size_t stored = 0;
  for (int i = 0; i < 20; ++i, take()) stored += fill(1, 1, 1);
  EXPECT_LE(stored * kLarge, HeldInstances::kMaxOctetsOfOne);
  EXPECT_GE(stored, 7u);
  EXPECT_GE(fill(3, 1, 4), 3u);
  EXPECT_LE(cache().held().octets(), HeldInstances::kMaxOctets);
}

// Otherwise a reader that does not take would be full after 65,536 samples of one identity.
TEST_F(Shares, OneIdentity_NeverTakesAllPlaces) {
  const auto store = [&](std::uint8_t from, std::size_t count) {
    std::size_t stored = 0;
    for (std::size_t i = 0; i < count; ++i)
      stored += put_octets(from, from, 1).outcome == StoreResult::stored ? 1 : 0;
    return stored;
  };
  constexpr auto kHalf = HeldInstances::kMaxSamples / 2;
  EXPECT_EQ(store(1, kHalf + 10), kHalf);
  EXPECT_EQ(store(3, kHalf), kHalf / 2);
  EXPECT_TRUE(put_octets(1, 1, 1).crowded);
  take();
  EXPECT_EQ(store(1, 10), 10u);
  EXPECT_EQ(cache().room_for({kHalf - 20, 1}, writer(1)), Room::now);
  EXPECT_EQ(cache().room_for({kHalf, 1}, writer(1)), Room::later);
  EXPECT_EQ(cache().room_for({kHalf + 1, 1}, writer(1)), Room::never);
  EXPECT_EQ(cache().room_for({1, HeldInstances::kMaxOctetsOfOne + 1}, writer(1)), Room::never);
}

// A sample that TIME_BASED_FILTER holds back is stored when its writer goes, and still counts for
// that writer.
TEST_F(Shares, WhatIsKeptForLater_CountsForItsWriter) {
  qos.time_based_filter = Duration::from(std::chrono::seconds(1));
  made.reset();
  qos.reliability.kind = ReliabilityKind::reliable;
  for (const auto i : kTwo) cache().set_writer(writer(i), 0, kDurationInfinite, writer(i).prefix);
  for (std::uint8_t key = 0; key < 20; ++key) put_octets(3, key, 1);
  for (std::uint8_t key = 0; key < 20; ++key) put_octets(1, key, kLarge);
  EXPECT_LE(cache().held().octets(), HeldInstances::kMaxOctetsOfOne + 100);
  const auto before = cache().held().octets();
  EXPECT_TRUE(cache().lose_writer(writer(1), ReaderCache::WriterLoss::unmatched, now));
  EXPECT_EQ(cache().held().octets(), before);
  now += std::chrono::seconds(2);
  EXPECT_FALSE(cache().release(moment()));
  EXPECT_EQ(cache().room_for({1, kLarge}, writer(3)), Room::now);
}

TEST_F(Shares, WhatFindsNoRoomToBeKeptForLater_IsRejectedAndTheFormerStays) {
  qos.time_based_filter = Duration::from(std::chrono::seconds(1));
  made.reset();
  qos.reliability.kind = ReliabilityKind::reliable;
  cache().set_writer(writer(1), 0, kDurationInfinite, writer(1).prefix);
  ASSERT_EQ(put_octets(1, 0, 1).outcome, StoreResult::stored);
  ASSERT_EQ(put_octets(1, 0, 2).outcome, StoreResult::dropped);  // it is kept for later
  std::uint8_t key = 1;
  while (put_octets(1, key, kLarge).outcome == StoreResult::stored) ++key;
  EXPECT_EQ(put_octets(1, 0, kLarge).outcome, StoreResult::rejected);
  take();
  now += std::chrono::seconds(2);
  EXPECT_TRUE(cache().release(moment()));
  const auto kept = take();
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_EQ(kept[0].payload.size(), 2u);
}

// Otherwise two other identities that hold back as much as they may would make the reader forget 37
// of 110 acknowledged samples.
TEST_F(Shares, WhatWasKeptForLater_IsNotLostWhenOthersFillTheirShares) {
  qos.time_based_filter = Duration::from(std::chrono::seconds(1));
  qos.reliability.kind = ReliabilityKind::reliable;
  qos.history = {HistoryKind::keep_last, 1};
  made.reset();
  constexpr std::size_t kMany = 7;
  for (std::uint8_t i = 1; i <= 3; ++i)
    cache().set_writer(writer(i), 0, kDurationInfinite, writer(i).prefix);
  for (std::uint8_t from = 1; from <= 3; ++from)
    for (std::uint8_t key = 0; key < kMany; ++key)
      put_octets(from, static_cast<std::uint8_t>(50 * from + key), 1);
  take();
  std::array<std::size_t, 4> kept{};
  for (std::uint8_t from = 1; from <= 3; ++from)
    for (std::uint8_t key = 0; key < kMany; ++key)
      kept[from] += put_octets(from, static_cast<std::uint8_t>(50 * from + key), kLarge).outcome ==
                            StoreResult::dropped
                        ? 1
                        : 0;
  ASSERT_EQ(kept[1], kMany);
  ASSERT_GT(kept[2], 2u);
  std::array<std::size_t, 4> got{};
  for (int turn = 0; turn < 10; ++turn) {
    now += std::chrono::seconds(1);
    cache().release(moment());
    for (const auto& sample : take()) ++got[sample.info.publication_handle.prefix.octets[0]];
  }
  EXPECT_EQ(got, kept);
}

// Instances that the first identity begins and leaves, and that another one also writes.
struct LeftInstances : Cache {
  LeftInstances() {
    for (std::uint8_t i = 1; i <= 3; ++i)
      cache().set_writer(writer(i), 0, kDurationInfinite, writer(i).prefix);
  }
  StoreResult put_many(std::uint8_t from, std::uint32_t key, StatusInfo status = {}) {
    Change change;
    change.writer = writer(from);
    change.status = status;
    auto& hash = change.key_hash.emplace();
    for (std::size_t at = 0; at < 4; ++at) hash[at] = static_cast<std::uint8_t>(key >> (8 * at));
    return cache().store(change, moment()).outcome;
  }
  static constexpr auto kHalf = static_cast<std::uint32_t>(HeldInstances::kMaxInstances / 2);
};

// Otherwise the other identity could keep 65,536 instances in the first one's account, which would
// lock the first one out for good.
TEST_F(LeftInstances, AnInstanceThatAnotherIdentityKeeps_CountsForThatOne) {
  std::uint32_t refused = 0, refused_of_other = 0;
  for (std::uint32_t key = 0; key < kHalf + 1000; ++key) {
    refused += put_many(1, key) == StoreResult::stored ? 0 : 1;
    refused_of_other += put_many(3, key) == StoreResult::stored ? 0 : 1;
    put_many(1, key, kUnregister);
    take();
  }
  EXPECT_EQ(refused, 0u);
  EXPECT_EQ(refused_of_other, 0u) << "as long as it is not alone with the instance";
  EXPECT_LE(cache().held().all().size(), kHalf + 1) << "no more than its share";
  EXPECT_EQ(put_many(3, 5'000'000), StoreResult::rejected) << "its own share is used up";
  EXPECT_EQ(put_many(1, 5'000'000), StoreResult::stored);
  EXPECT_EQ(put_many(2, 6'000'000), StoreResult::stored);
}

TEST_F(LeftInstances, InstanceWithoutRoomInAnAccount_StaysInTheLastOneThatHadRoom) {
  for (std::uint32_t key = 0; key < kHalf; ++key) {
    ASSERT_EQ(put_many(3, key), StoreResult::stored);
    if (key % 1000 == 0) take();
  }
  take();
  EXPECT_EQ(put_many(1, 1'000'000), StoreResult::stored);
  EXPECT_EQ(put_many(3, 1'000'000), StoreResult::stored);
  EXPECT_EQ(put_many(1, 1'000'000, kUnregister), StoreResult::stored);
  EXPECT_EQ(put_many(3, 1'000'000), StoreResult::rejected) << "it would be its own";
  EXPECT_EQ(put_many(1, 1'000'000), StoreResult::stored) << "it begins again";
  EXPECT_EQ(put_many(3, 1'000'000), StoreResult::stored);
}

TEST_F(LeftInstances, WhatIsKeptForLater_KeepsNoInstanceInTheAccountOfAnother) {
  qos.time_based_filter = Duration::from(std::chrono::seconds(1));
  qos.reliability.kind = ReliabilityKind::reliable;
  made.reset();
  for (const std::uint8_t i : {1, 3})
    cache().set_writer(writer(i), 0, kDurationInfinite, writer(i).prefix);
  for (std::uint32_t key = 0; key < kHalf; ++key) {
    ASSERT_EQ(put_many(3, key), StoreResult::stored);
    if (key % 1000 == 0) take();
  }
  take();
  ASSERT_EQ(put_many(1, 1'000'000), StoreResult::stored);
  take();
  EXPECT_EQ(put_many(3, 1'000'000), StoreResult::dropped) << "kept for later";
  EXPECT_EQ(put_many(1, 1'000'000, kUnregister), StoreResult::stored);
  take();
  EXPECT_EQ(cache().held().all().size(), kHalf) << "it has ended";
  ASSERT_EQ(put_many(1, 2'000'000), StoreResult::stored);
  EXPECT_EQ(put_many(1, 2'000'000, kUnregister), StoreResult::stored);
  EXPECT_EQ(put_many(3, 2'000'000), StoreResult::rejected) << "not even kept for later";
}

TEST_F(ReaderCacheTest, Memory_IsBoundedWhateverTheLimits) {
  const auto large = [&](std::uint8_t key) {
    Change change;
    change.key_hash = KeyHash{key};
    change.payload = Payload::uninitialized(std::size_t{64} << 20);
    return cache().store(change, moment()).outcome;
  };
  for (std::uint8_t i = 0; i < 3; ++i) EXPECT_EQ(large(i), StoreResult::stored);
  EXPECT_EQ(large(3), StoreResult::rejected);
  EXPECT_LE(cache().held().octets(), HeldInstances::kMaxOctets);
}

// If each end were compared with all that is held, so many would take 16 s of CPU.
TEST_F(ReaderCacheTest, EndsOfManySamples_CostEachTheirOwn) {
  constexpr int kMany = 60'000;
  cache().set_writer(writer(1), 0, Duration::from(std::chrono::seconds(1)));
  for (int i = 0; i < kMany; ++i) {
    now += std::chrono::microseconds(10);
    put(1, 1);
  }
  const auto begin = std::clock();
  for (int left = kMany; left > 0; --left) ASSERT_TRUE(cache().expire(cache().next_tick()));
  EXPECT_LT(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC, 3);
  EXPECT_EQ(cache().held().samples(), 0u);
}

Guid writer_of(std::uint8_t identity, std::uint32_t number) {
  auto out = writer(identity);
  out.entity.octets[0] = static_cast<std::uint8_t>(number >> 8);
  out.entity.octets[1] = static_cast<std::uint8_t>(number);
  return out;
}

struct InstanceJoins : Cache {
  // Returns false if the join was rejected.
  bool join(const Guid& by, std::uint32_t instance) {
    Change change;
    change.writer = by;
    auto& key = change.key_hash.emplace();
    for (std::size_t at = 0; at < 4; ++at)
      key[at] = static_cast<std::uint8_t>(instance >> (8 * at));
    return cache().store(change, moment()).outcome == StoreResult::stored;
  }
  double seconds_since(std::clock_t begin) const {
    return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  }
};

// Without the bound, 1024 writers of one identity with 8192 instances took 649 MB, and 107 s when
// they left.
TEST_F(InstanceJoins, OneIdentity_IsBoundedAndLeavesRoomForAnother) {
  qos.history = {HistoryKind::keep_last, 1};
  constexpr std::uint32_t kWriters = 1024, kInstances = 1024;
  std::size_t joined = 0;
  for (std::uint32_t w = 0; w < kWriters; ++w) {
    cache().set_writer(writer_of(1, w), 0, kDurationInfinite, writer(1).prefix);
    for (std::uint32_t i = 0; i < kInstances; ++i) joined += join(writer_of(1, w), i) ? 1 : 0;
  }
  EXPECT_EQ(joined, InstanceWriters::kMax / 2);
  EXPECT_TRUE(join(writer_of(1, 0), 0)) << "it has the instance already";
  EXPECT_FALSE(join(writer_of(1, 0), 2'000'000));
  cache().set_writer(writer(2), 0, kDurationInfinite, writer(2).prefix);
  EXPECT_TRUE(join(writer(2), 7));
  EXPECT_TRUE(join(writer(2), 3'000'000));
  const auto begin = std::clock();
  for (std::uint32_t w = 0; w < kWriters; ++w)
    cache().lose_writer(writer_of(1, w), ReaderCache::WriterLoss::unmatched, now);
  EXPECT_LT(seconds_since(begin), 3);
  take();
  EXPECT_EQ(cache().held().all().size(), 2u);
  cache().set_writer(writer_of(1, 0), 0, kDurationInfinite, writer(1).prefix);
  EXPECT_TRUE(join(writer_of(1, 0), 9)) << "what has left makes room";
}

// If the cost of a sample grew with their number, this would take 83 s.
TEST_F(InstanceJoins, SamplesOfOneInstance_InTheOppositeOrderOfTheirTimes_CostEachTheirOwn) {
  qos.destination_order = DestinationOrderKind::by_source;
  constexpr int kCount = 60'000;
  const auto begin = std::clock();
  for (int i = kCount; i > 0; --i) put(1, 0, {}, 1, now - std::chrono::microseconds(i % 2 + i));
  EXPECT_EQ(cache().held().samples(), static_cast<std::size_t>(kCount));
  EXPECT_LT(seconds_since(begin), 3);
  const auto all = take();
  ASSERT_EQ(all.size(), static_cast<std::size_t>(kCount));
  EXPECT_TRUE(std::ranges::is_sorted(
      all, {}, [](const OctetSample& sample) { return sample.info.source_timestamp; }));
}

// A sample must not search among all samples for the one that reports the end.
TEST_F(InstanceJoins, SamplesAfterAnEndThatWasNotRead_CostEachTheirOwn) {
  constexpr int kCount = 60'000;
  for (int i = 0; i < kCount; ++i) put(1, 0);
  put(1, 0, kDispose);
  const auto begin = std::clock();
  for (int i = 0; i < kCount; ++i) put(1, 0);
  EXPECT_LT(seconds_since(begin), 3);
  EXPECT_EQ(take().size(), static_cast<std::size_t>(2 * kCount + 1));
}

}  // namespace
}  // namespace ddssec::rtps
