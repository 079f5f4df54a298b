// What a reader holds, by itself: states, generations, ranks, limits, ownership, time.
#include "rtps/dcps/reader_cache.hpp"

#include <ctime>

#include <gmock/gmock.h>

namespace ddssec::rtps {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using Outcome = ReaderCache::Outcome;
using Reason = SampleRejectedReason;

constexpr StatusInfo kDispose{true, false}, kUnregister{false, true}, kBoth{true, true};

Guid writer(std::uint8_t n) { return {GuidPrefix::from(Bytes(12, n)), EntityId{{0, 0, 1, 2}}}; }

struct Cache : ::testing::Test {
  Qos qos = [] {
    Qos all;
    all.history.kind = HistoryKind::keep_all;
    return all;
  }();
  std::optional<ReaderCache> made;
  MonotonicTime now = std::chrono::seconds(100);

  ReaderCache& cache() {
    if (!made)
      made.emplace(qos, [](const Change& change) { return Bytes{change.key_hash.value()[0]}; });
    return *made;
  }
  Moment moment() const { return {now, Time::from(now)}; }
  /// A change of `key`, stamped `at` after the start.
  ReaderCache::Stored put(std::uint8_t key, std::uint8_t value, StatusInfo status = {},
                          std::uint8_t from = 1, std::optional<MonotonicTime> stamp = {}) {
    Change change;
    change.writer = writer(from);
    change.key_hash = KeyHash{key};
    change.status = status;
    change.key_only = status != StatusInfo{};
    change.source_time = Time::from(stamp.value_or(now));
    change.payload = Payload::copy_of(Bytes{value});
    return cache().store(change, moment());
  }
  std::vector<OctetSample> select(Query query) {
    std::vector<OctetSample> out;
    cache().select(query, moment(), out);
    return out;
  }
  std::vector<OctetSample> take(States states = {}) {
    return select({.states = states, .take = true});
  }
  std::vector<OctetSample> read(States states = {}) { return select({.states = states}); }
  /// First octet of each: the value, or the key where there is no data.
  static std::vector<int> values(const std::vector<OctetSample>& samples) {
    std::vector<int> out;
    for (const auto& sample : samples) out.push_back(sample.payload.view()[0]);
    return out;
  }
};
using ReaderCacheTest = Cache;

TEST_F(ReaderCacheTest, ReadKeepsAndTakeRemoves) {
  put(1, 10), put(1, 11);
  auto first = read();
  EXPECT_THAT(values(first), ElementsAre(10, 11));
  EXPECT_EQ(first[0].info.sample_state, SampleState::not_read);
  EXPECT_EQ(first[0].info.view_state, ViewState::new_);
  EXPECT_EQ(first[0].info.publication_handle, writer(1));
  EXPECT_EQ(first[0].info.instance_handle, cache().lookup(KeyHash{1}));
  put(1, 12);
  EXPECT_THAT(values(read({.sample = SampleState::not_read})), ElementsAre(12));
  auto all = take();
  EXPECT_THAT(values(all), ElementsAre(10, 11, 12));
  EXPECT_EQ(all[0].info.sample_state, SampleState::read);
  EXPECT_EQ(all[0].info.view_state, ViewState::not_new);
  EXPECT_THAT(take(), IsEmpty());
  EXPECT_EQ(cache().samples(), 0u);
  EXPECT_EQ(cache().instances(), 1u);  // its writer lives
}

TEST_F(ReaderCacheTest, SamplesOfAnInstanceStandTogetherAndMostIsKept) {
  put(1, 10), put(2, 20), put(1, 11), put(2, 21);
  EXPECT_THAT(values(read()), ElementsAre(10, 11, 20, 21));
  EXPECT_THAT(values(select({.most = 3, .take = true})), ElementsAre(10, 11, 20));
  EXPECT_THAT(values(take()), ElementsAre(21));
}

TEST_F(ReaderCacheTest, ByInstanceAndByNextInstance) {
  put(1, 10), put(2, 20), put(3, 30);
  const auto second = cache().lookup(KeyHash{2});
  using Scope = Query::Scope;
  EXPECT_THAT(values(select({.scope = Scope::instance, .instance = second})), ElementsAre(20));
  EXPECT_THAT(values(select({.scope = Scope::next_instance})), ElementsAre(10));
  EXPECT_THAT(values(select({.scope = Scope::next_instance, .instance = second})), ElementsAre(30));
  EXPECT_THAT(select({.scope = Scope::next_instance, .instance = cache().lookup(KeyHash{3})}),
              IsEmpty());
  EXPECT_THAT(select({.scope = Scope::instance, .instance = {99}}), IsEmpty());
  EXPECT_THAT(
      values(select({.states = {.sample = SampleState::not_read}, .scope = Scope::next_instance})),
      IsEmpty());
  put(3, 31);
  EXPECT_THAT(
      values(select({.states = {.sample = SampleState::not_read}, .scope = Scope::next_instance})),
      ElementsAre(31));
}

TEST_F(ReaderCacheTest, AnInstanceEndsAndComesBackAsANewGeneration) {
  put(1, 10), put(1, 0, kDispose);
  auto samples = read();
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_EQ(samples[1].info.instance_state, InstanceState::not_alive_disposed);
  EXPECT_FALSE(samples[1].info.valid_data);
  EXPECT_TRUE(samples[1].key_only);
  EXPECT_EQ(samples[1].payload.view()[0], 1);  // the key
  put(1, 11);                                  // what said "disposed" was read: it is over
  put(1, 0, kUnregister);
  put(1, 12);
  samples = take();
  EXPECT_THAT(values(samples), ElementsAre(10, 11, 1, 12));
  for (const auto& sample : samples) {
    EXPECT_EQ(sample.info.instance_state, InstanceState::alive);
    EXPECT_EQ(sample.info.view_state, ViewState::new_);
  }
  const auto generations = [&](std::size_t i) {
    return std::pair(samples[i].info.disposed_generation_count,
                     samples[i].info.no_writers_generation_count);
  };
  EXPECT_EQ(generations(0), std::pair(0, 0));
  EXPECT_EQ(generations(1), std::pair(1, 0));
  EXPECT_EQ(generations(3), std::pair(1, 1));
  EXPECT_EQ(samples[0].info.sample_rank, 3);
  EXPECT_EQ(samples[3].info.sample_rank, 0);
  EXPECT_EQ(samples[0].info.generation_rank, 2);
  EXPECT_EQ(samples[1].info.generation_rank, 1);
  EXPECT_EQ(samples[0].info.absolute_generation_rank, 2);
}

TEST_F(ReaderCacheTest, RanksCountTheCollectionAndTheReader) {
  put(1, 10), put(1, 0, kDispose), put(1, 11), put(1, 0, kDispose), put(1, 12);
  const auto first = select({.most = 2});
  EXPECT_EQ(first[0].info.sample_rank, 1);
  EXPECT_EQ(first[0].info.generation_rank, 1);
  EXPECT_EQ(first[0].info.absolute_generation_rank, 2);
}

TEST_F(ReaderCacheTest, AnInstanceWithoutWritersSaysSoAndIsForgottenOnceTaken) {
  put(1, 10, {}, 1), put(1, 11, {}, 2), put(2, 20, {}, 2);
  EXPECT_FALSE(cache().lose_writer(writer(1), true, now));
  EXPECT_EQ(read({.instance = InstanceState::alive}).size(), 3u);
  EXPECT_TRUE(cache().lose_writer(writer(2), true, now));
  const auto samples = take();
  ASSERT_EQ(samples.size(), 5u);
  EXPECT_EQ(samples[0].info.instance_state, InstanceState::not_alive_no_writers);
  EXPECT_FALSE(samples[2].info.valid_data);
  EXPECT_EQ(cache().instances(), 0u);
  EXPECT_EQ(cache().octets(), 0u);
}

TEST_F(ReaderCacheTest, DisposedAndUnregisteredAtOnceIsDisposed) {
  put(1, 10), put(1, 0, kBoth);
  EXPECT_EQ(take().back().info.instance_state, InstanceState::not_alive_disposed);
  EXPECT_EQ(cache().instances(), 0u);
  EXPECT_EQ(put(7, 0, kUnregister).outcome, Outcome::dropped);  // never heard of
  EXPECT_EQ(cache().instances(), 0u);
}

TEST_F(ReaderCacheTest, AnyKnowsWhatSelectWouldFind) {
  const States fresh{.sample = SampleState::not_read}, ended{.instance = kNotAlive};
  EXPECT_FALSE(cache().any({}));
  put(1, 10);
  EXPECT_TRUE(cache().any(fresh));
  EXPECT_FALSE(cache().any(ended));
  read();
  EXPECT_FALSE(cache().any(fresh));
  EXPECT_TRUE(cache().any({.sample = SampleState::read, .view = ViewState::not_new}));
  put(1, 0, kDispose);
  EXPECT_TRUE(cache().any(fresh) && cache().any(ended));
  take();
  EXPECT_FALSE(cache().any({}));
}

TEST_F(ReaderCacheTest, KeepLastReplacesTheOldestOfItsInstance) {
  qos.history = {HistoryKind::keep_last, 2};
  for (std::uint8_t i = 0; i < 5; ++i) put(1, i), put(2, i);
  EXPECT_THAT(values(take()), ElementsAre(3, 4, 3, 4));
}

TEST_F(ReaderCacheTest, EachLimitRejectsByItsNameAndChangesNothing) {
  qos.resource_limits = {.max_samples = 3, .max_instances = 2, .max_samples_per_instance = 2};
  put(1, 10), put(1, 11);
  EXPECT_EQ(put(1, 12).reason, Reason::by_samples_per_instance_limit);
  put(2, 20);
  const auto rejected = put(2, 21);
  EXPECT_EQ(rejected.reason, Reason::by_samples_limit);
  EXPECT_EQ(rejected.instance, cache().lookup(KeyHash{2}));
  EXPECT_EQ(put(3, 30).reason, Reason::by_instances_limit);
  EXPECT_EQ(cache().samples(), 3u);
  EXPECT_THAT(values(take()), ElementsAre(10, 11, 20));
  EXPECT_EQ(put(2, 21).outcome, Outcome::stored);
  // A limit of samples is none for what says that an instance ended.
  put(1, 12), put(1, 13);
  EXPECT_EQ(put(1, 0, kDispose).outcome, Outcome::stored);
}

TEST_F(ReaderCacheTest, AnEndedInstanceMakesRoomForANewOne) {
  qos.resource_limits.max_instances = 2;
  put(1, 10), put(2, 20), put(1, 0, kDispose);
  EXPECT_EQ(put(3, 30).reason, Reason::by_instances_limit);
  take();
  EXPECT_EQ(put(3, 30).outcome, Outcome::stored);
  EXPECT_TRUE(cache().lookup(KeyHash{1}).is_nil());
}

// One identity took all 65,536, and no other writer was heard.
TEST_F(ReaderCacheTest, NoIdentityTakesAllInstances) {
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
      stored += cache().store(change, moment()).outcome == Outcome::stored ? 1 : 0;
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
  cache().lose_writer(writer(1), true, now);
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
  ReaderCache::Stored put_octets(std::uint8_t from, std::uint8_t key, std::size_t octets) {
    Change change;
    change.writer = writer(from);
    change.key_hash = KeyHash{key};
    change.payload = Payload::uninitialized(octets);
    return cache().store(change, moment());
  }
  /// How many samples are stored, each of an instance of its own.
  std::size_t fill(std::uint8_t from, std::size_t octets, std::size_t count) {
    std::size_t stored = 0;
    for (std::size_t i = 0; i < count; ++i, ++keys)
      stored += put_octets(from, keys, octets).outcome == Outcome::stored ? 1 : 0;
    return stored;
  }
  std::uint8_t keys = 0;
};

// One identity took all octets, and the samples of others were rejected as long as its own stayed.
TEST_F(Shares, NoIdentityTakesAllOctets) {
  constexpr auto kHalf = HeldInstances::kMostOctetsOfOne / kLarge;
  EXPECT_EQ(fill(1, kLarge, 20), kHalf);
  EXPECT_EQ(fill(2, kLarge, 2), 0u) << "another participant of the same identity";
  const auto refused = put_octets(1, keys, kLarge);
  EXPECT_EQ(refused.reason, Reason::by_samples_limit);
  EXPECT_TRUE(refused.crowded);
  EXPECT_EQ(fill(3, kLarge, 20), kHalf / 2);
  cache().lose_writer(writer(1), true, now);
  cache().lose_writer(writer(2), true, now);
  EXPECT_EQ(fill(3, kLarge, 2), 0u) << "the samples are still held";
  take();
  EXPECT_EQ(cache().octets(), 0u + cache().instances()) << "nothing but keys";
  EXPECT_EQ(fill(3, kLarge, 20), kHalf) << "their room is free again";
}

TEST_F(Shares, OwnSamplesGiveWayInAFullShare) {
  qos.history = {HistoryKind::keep_last, 1};
  made.reset();
  cache().set_writer(writer(1), 0, kDurationInfinite, writer(1).prefix);
  ASSERT_GT(fill(1, kLarge, 20), 0u);
  EXPECT_EQ(put_octets(1, 0, kLarge).outcome, Outcome::stored);
  EXPECT_EQ(put_octets(1, 100, kLarge).outcome, Outcome::rejected);
}

// A reader that takes all samples holds the keys as long as the instances are alive.
TEST_F(Shares, NoIdentityTakesAllOctetsWithKeys) {
  made.emplace(qos, [](const Change&) { return Bytes(kLarge); });
  for (const auto i : kTwo) cache().set_writer(writer(i), 0, kDurationInfinite, writer(i).prefix);
  std::size_t stored = 0;
  for (int i = 0; i < 20; ++i, take()) stored += fill(1, 1, 1);
  EXPECT_LE(stored * kLarge, HeldInstances::kMostOctetsOfOne);
  EXPECT_GE(stored, 7u);
  EXPECT_GE(fill(3, 1, 4), 3u);
  EXPECT_LE(cache().octets(), HeldInstances::kMaxOctets);
}

// A reader that does not take was full after 65,536 samples of one identity.
TEST_F(Shares, NoIdentityTakesAllPlaces) {
  const auto store = [&](std::uint8_t from, std::size_t count) {
    std::size_t stored = 0;
    for (std::size_t i = 0; i < count; ++i)
      stored += put_octets(from, from, 1).outcome == Outcome::stored ? 1 : 0;
    return stored;
  };
  constexpr auto kHalf = HeldInstances::kMaxSamples / 2;
  EXPECT_EQ(store(1, kHalf + 10), kHalf);
  EXPECT_EQ(store(3, kHalf), kHalf / 2);
  EXPECT_TRUE(put_octets(1, 1, 1).crowded);
  take();
  EXPECT_EQ(store(1, 10), 10u);
  EXPECT_EQ(cache().room_for(kHalf - 20, 1, writer(1)), Room::now);
  EXPECT_EQ(cache().room_for(kHalf, 1, writer(1)), Room::later);
  EXPECT_EQ(cache().room_for(kHalf + 1, 1, writer(1)), Room::never);
  EXPECT_EQ(cache().room_for(1, HeldInstances::kMostOctetsOfOne + 1, writer(1)), Room::never);
}

// Samples of a writer that is gone still count when TIME_BASED_FILTER releases them.
TEST_F(Shares, WhatIsKeptForLaterCountsForItsWriter) {
  qos.time_based_filter = Duration::from(std::chrono::seconds(1));
  made.reset();
  qos.reliability.kind = ReliabilityKind::reliable;
  for (const auto i : kTwo) cache().set_writer(writer(i), 0, kDurationInfinite, writer(i).prefix);
  for (std::uint8_t key = 0; key < 20; ++key) put_octets(3, key, 1);
  for (std::uint8_t key = 0; key < 20; ++key) put_octets(1, key, kLarge);
  EXPECT_LE(cache().octets(), HeldInstances::kMostOctetsOfOne + 100);
  cache().lose_writer(writer(1), true, now);
  now += std::chrono::seconds(2);
  EXPECT_TRUE(cache().release(moment()));
  EXPECT_LE(cache().octets(), HeldInstances::kMostOctetsOfOne + 100);
  EXPECT_EQ(cache().room_for(1, kLarge, writer(3)), Room::now);
}

TEST_F(ReaderCacheTest, MemoryIsBoundedWhateverTheLimits) {
  const auto large = [&](std::uint8_t key) {
    Change change;
    change.key_hash = KeyHash{key};
    change.payload = Payload::uninitialized(std::size_t{64} << 20);
    return cache().store(change, moment()).outcome;
  };
  for (std::uint8_t i = 0; i < 3; ++i) EXPECT_EQ(large(i), Outcome::stored);
  EXPECT_EQ(large(3), Outcome::rejected);
  EXPECT_LE(cache().octets(), HeldInstances::kMaxOctets);
}

TEST_F(ReaderCacheTest, TheStrongestWriterOwnsAnInstance) {
  qos.ownership = OwnershipKind::exclusive;
  cache().set_writer(writer(1), 5, kDurationInfinite);
  cache().set_writer(writer(2), 10, kDurationInfinite);
  put(1, 10, {}, 1);
  put(1, 20, {}, 2);
  EXPECT_EQ(put(1, 11, {}, 1).outcome, Outcome::dropped);
  EXPECT_EQ(put(1, 0, kDispose, 1).outcome, Outcome::dropped);
  put(2, 12, {}, 1);  // nobody stronger writes this one
  EXPECT_THAT(values(take()), ElementsAre(10, 20, 12));
  cache().set_writer(writer(1), 11, kDurationInfinite);
  put(1, 13, {}, 1);
  EXPECT_EQ(put(1, 21, {}, 2).outcome, Outcome::dropped);
  EXPECT_THAT(values(take()), ElementsAre(13));
}

TEST_F(ReaderCacheTest, EquallyStrongWritersAreDecidedByTheirGuid) {
  qos.ownership = OwnershipKind::exclusive;
  put(1, 20, {}, 2), put(1, 10, {}, 1), put(1, 21, {}, 2);
  EXPECT_THAT(values(take()), ElementsAre(20, 10));
}

TEST_F(ReaderCacheTest, OwnershipPassesOnWhenItsOwnerGoesUnregistersOrIsLate) {
  qos.ownership = OwnershipKind::exclusive;
  qos.deadline = Duration::from(milliseconds(100));
  cache().set_writer(writer(1), 1, kDurationInfinite);
  cache().set_writer(writer(2), 2, kDurationInfinite);
  const auto weak_is_heard = [&] {
    const auto outcome = put(1, 10, {}, 1).outcome;
    put(1, 20, {}, 2);
    return outcome == Outcome::stored;
  };
  EXPECT_TRUE(weak_is_heard());
  EXPECT_FALSE(weak_is_heard());
  cache().lose_writer(writer(2), false, now);
  EXPECT_TRUE(weak_is_heard());
  put(1, 0, kUnregister, 2);
  EXPECT_TRUE(weak_is_heard());
  now += milliseconds(150);
  cache().check_deadlines(now, [](InstanceHandle) {});
  EXPECT_TRUE(weak_is_heard());
  EXPECT_THAT(take({.instance = kNotAlive}), IsEmpty());  // a weaker writer was there all the time
}

TEST_F(ReaderCacheTest, BySourceOrdersAndNeverGoesBack) {
  qos.destination_order = DestinationOrderKind::by_source;
  put(1, 12, {}, 1, milliseconds(2)), put(1, 11, {}, 2, milliseconds(1));
  EXPECT_THAT(values(take()), ElementsAre(11, 12));
  EXPECT_EQ(put(1, 10, {}, 2, milliseconds(1)).outcome, Outcome::dropped);
  put(1, 15, {}, 1, milliseconds(5));
  EXPECT_EQ(put(1, 0, kDispose, 2, milliseconds(4)).outcome, Outcome::dropped);
  put(1, 14, {}, 2, milliseconds(4));
  EXPECT_THAT(values(take()), ElementsAre(14, 15));
}

// One sample from the far future ended what all others wrote to the instance.
TEST_F(ReaderCacheTest, BySourceATimeFarAheadCountsAsArrival) {
  qos.destination_order = DestinationOrderKind::by_source;
  constexpr auto kMost = ReaderCache::kMostAhead;
  put(1, 10, {}, 1, now + std::chrono::hours(100'000));
  EXPECT_EQ(cache().times_ahead(), 1u);
  EXPECT_EQ(take().at(0).info.source_timestamp, Time::from(now));
  now += milliseconds(1);
  EXPECT_EQ(put(1, 11, {}, 2).outcome, Outcome::stored);
  EXPECT_EQ(put(1, 12, {}, 1, now + kMost).outcome, Outcome::stored) << "as far as is allowed";
  EXPECT_EQ(cache().times_ahead(), 1u);
  EXPECT_EQ(put(1, 0, kDispose, 2, now + kMost + milliseconds(1)).outcome, Outcome::dropped)
      << "it ends nothing that was written later";
  EXPECT_EQ(cache().times_ahead(), 2u);
  EXPECT_THAT(values(take()), ElementsAre(11, 12));
  now += kMost + milliseconds(1);
  EXPECT_EQ(put(1, 13, {}, 2).outcome, Outcome::stored);
}

TEST_F(ReaderCacheTest, BySourceAFullHistoryKeepsTheNewest) {
  qos.destination_order = DestinationOrderKind::by_source;
  qos.history = {HistoryKind::keep_last, 2};
  put(1, 12, {}, 1, milliseconds(2)), put(1, 13, {}, 1, milliseconds(3));
  EXPECT_EQ(put(1, 11, {}, 2, milliseconds(1)).outcome, Outcome::dropped);
  put(1, 14, {}, 2, milliseconds(4));
  EXPECT_THAT(values(take()), ElementsAre(13, 14));
}

TEST_F(ReaderCacheTest, LifespanEndsSamplesFromTheirSourceTimeOn) {
  cache().set_writer(writer(1), 0, Duration::from(milliseconds(100)));
  put(1, 10), put(1, 11, {}, 2);
  EXPECT_EQ(put(1, 12, {}, 1, now - milliseconds(100)).outcome, Outcome::dropped);
  put(1, 13, {}, 1, now - milliseconds(60));
  put(1, 14, {}, 1, now + std::chrono::hours(1));  // a clock ahead of ours
  EXPECT_EQ(cache().next_tick(), now + milliseconds(40));
  now += milliseconds(50);
  EXPECT_THAT(values(read()), ElementsAre(10, 11, 14));
  now += milliseconds(50);
  EXPECT_TRUE(cache().expire(now));
  EXPECT_THAT(values(take()), ElementsAre(11));
  EXPECT_EQ(cache().next_tick(), kNever);
}

TEST_F(ReaderCacheTest, SamplesExpireInAnyOrderAndWhenTheyAreTaken) {
  cache().set_writer(writer(1), 0, Duration::from(milliseconds(100)));
  for (int i = 0; i < 10; ++i)
    put(static_cast<std::uint8_t>(i % 2), static_cast<std::uint8_t>(i), {}, 1,
        now - milliseconds(10 * (i * 7 % 10)));
  (void)select({.most = 3, .take = true});
  std::size_t left = cache().samples();
  for (; left > 0; --left) {
    const auto next = cache().next_tick();
    ASSERT_NE(next, kNever);
    EXPECT_FALSE(cache().expire(next - std::chrono::nanoseconds(1)));
    EXPECT_TRUE(cache().expire(next));
    EXPECT_EQ(cache().samples(), left - 1);
  }
  EXPECT_EQ(cache().next_tick(), kNever);
}

// Before: each end looked at all that was held, 16 s of CPU for so many.
TEST_F(ReaderCacheTest, EndsOfManySamplesCostEachTheirOwn) {
  constexpr int kMany = 60'000;
  cache().set_writer(writer(1), 0, Duration::from(std::chrono::seconds(1)));
  for (int i = 0; i < kMany; ++i) {
    now += std::chrono::microseconds(10);
    put(1, 1);
  }
  const auto begin = std::clock();
  for (int left = kMany; left > 0; --left) ASSERT_TRUE(cache().expire(cache().next_tick()));
  EXPECT_LT(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC, 3);
  EXPECT_EQ(cache().samples(), 0u);
}

TEST_F(ReaderCacheTest, DeadlinesAreOfEachInstance) {
  qos.deadline = Duration::from(milliseconds(100));
  std::vector<InstanceHandle> missed;
  const auto check = [&] { cache().check_deadlines(now, [&](auto i) { missed.push_back(i); }); };
  put(1, 10);
  now += milliseconds(60);
  put(2, 20);
  now += milliseconds(60);
  check();
  const auto one = cache().lookup(KeyHash{1}), two = cache().lookup(KeyHash{2});
  EXPECT_THAT(missed, ElementsAre(one));
  EXPECT_EQ(cache().next_tick(), now + milliseconds(40));
  put(2, 0, kDispose);  // nothing is expected of it any more
  now += milliseconds(100);
  check();
  EXPECT_THAT(missed, ElementsAre(one, one));
  cache().set_deadline(kDurationInfinite, now);
  EXPECT_EQ(cache().next_tick(), kNever);
  cache().set_deadline(kDurationZero, now);
  now += milliseconds(1);
  check();
  EXPECT_EQ(missed.size(), 3u);
  EXPECT_NE(missed.back(), two);
}

TEST_F(ReaderCacheTest, TheKeyIsKnownWhileTheInstanceIs) {
  put(5, 50);
  const auto instance = cache().lookup(KeyHash{5});
  ASSERT_NE(cache().key_value(instance), nullptr);
  EXPECT_EQ(cache().key_value(instance)->view()[0], 5);
  EXPECT_EQ(cache().key_value({99}), nullptr);
}

TEST_F(ReaderCacheTest, AMillionSamplesThroughAFewInstancesGrowNothing) {
  for (int i = 0; i < 20'000; ++i) {
    put(static_cast<std::uint8_t>(i % 7), 1);
    if (i % 50 == 0) take();
  }
  take();
  EXPECT_EQ(cache().octets(), 7u);  // the keys
  EXPECT_FALSE(cache().any({}));
}

TEST_F(ReaderCacheTest, WhatEndedIsPurgedAfterItsDelay) {
  qos.reader_data_lifecycle = {Duration::from(milliseconds(100)), Duration::from(milliseconds(50))};
  put(1, 10), put(2, 20), put(3, 30);
  put(1, 1, kDispose), put(2, 2, kUnregister);
  EXPECT_EQ(cache().next_tick(), now + milliseconds(50));
  now += milliseconds(50);
  EXPECT_TRUE(cache().expire(now));
  EXPECT_THAT(values(read()), ElementsAre(20, 2, 30));
  put(2, 21);  // comes back in time
  now += milliseconds(100);
  EXPECT_FALSE(cache().expire(now));
  EXPECT_EQ(cache().next_tick(), kNever);
  cache().lose_writer(writer(1), true, now);
  now += milliseconds(100);
  EXPECT_TRUE(cache().expire(now));
  EXPECT_THAT(read(), IsEmpty());
  EXPECT_EQ(cache().instances(), 0u);
  EXPECT_EQ(cache().octets(), 0u);
  EXPECT_FALSE(cache().any({}));
}

TEST_F(ReaderCacheTest, ADisposedInstanceThatLosesItsWritersIsPurgedAsDisposed) {
  qos.reader_data_lifecycle = {Duration::from(milliseconds(10)), Duration::from(milliseconds(50))};
  put(1, 10), put(1, 1, kDispose);
  cache().lose_writer(writer(1), true, now);
  now += milliseconds(20);
  EXPECT_FALSE(cache().expire(now));
  qos.reader_data_lifecycle = {};
  cache().set_lifecycle(qos.reader_data_lifecycle);  // for later ends
  now += milliseconds(30);
  EXPECT_TRUE(cache().expire(now));
  EXPECT_EQ(cache().instances(), 0u);
}

}  // namespace
}  // namespace ddssec::rtps
