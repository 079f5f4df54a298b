// The samples that a reader holds, tested alone: states, generations, ranks, limits, ownership,
// time.
#include <ctime>
#include <random>
#include <set>

#include "tests/support/slowdown.hpp"
#include "tests/unit/rtps/reader_cache_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

using ReaderCacheTest = Cache;

// The instance must not end with a keeper that sent the writer's sample first.
TEST_F(ReaderCacheTest, AWriter_WhoseSampleCameFromAnotherFirst_KeepsItsInstanceAlive) {
  put(1, 10, {}, 2);
  Change own;
  own.writer = writer(1);
  own.key_hash = KeyHash{1};
  EXPECT_FALSE(cache().is_wanted_again(own));
  put(1, 0, kUnregister, 2);
  const auto samples = read();
  ASSERT_FALSE(samples.empty());
  EXPECT_EQ(samples.back().info.instance_state, InstanceState::alive);
}

// Returns a change of another writer, sent by a durability service.
Change relayed(std::uint8_t relay, std::uint8_t from, std::int64_t number, std::uint8_t value) {
  Change change;
  change.writer = writer(relay);
  change.original = {writer(from), {number}};
  change.key_hash = KeyHash{1};
  change.source_time = Time{{static_cast<std::int32_t>(number), 0}};
  change.payload = Payload::copy_of(Bytes{value});
  return change;
}

// Otherwise a late joiner could end with an older sample, from a durability service that missed an
// update.
TEST_F(ReaderCacheTest, KeepLast_AnOlderSampleOfTheSameWriter_ReplacesNoLaterOne) {
  qos.history = {HistoryKind::keep_last, 1};
  const auto store = [&](Change change) { return cache().store(change, moment()).outcome; };
  EXPECT_EQ(store(relayed(8, 1, 7, 70)), StoreResult::stored);
  EXPECT_EQ(store(relayed(9, 1, 5, 50)), StoreResult::dropped);
  EXPECT_THAT(values(read()), ElementsAre(70));
  auto restarted = relayed(9, 1, 2, 20);
  restarted.source_time = Time{{100, 0}};
  EXPECT_EQ(store(restarted), StoreResult::stored) << "with the same GUID";
  EXPECT_EQ(store(relayed(9, 2, 1, 10)), StoreResult::stored) << "of another writer";
  EXPECT_THAT(values(take()), ElementsAre(10));
}

// Otherwise a set that the reader can never hold would be seen sample by sample.
TEST_F(ReaderCacheTest, KeepLast_RoomForASet_IsThatOfItsHistory) {
  qos.history = {HistoryKind::keep_last, 2};
  qos.resource_limits.max_samples = 4;
  const auto room = [&](std::map<KeyHash, std::size_t> instances) {
    WantedRoom wanted;
    for (const auto& [key, samples] : instances) wanted.samples += samples;
    wanted.octets = wanted.samples;
    wanted.instances = std::move(instances);
    return cache().room_for(wanted, writer(1));
  };
  EXPECT_EQ(room({{{1}, 2}, {{2}, 100}}), Room::now);
  EXPECT_EQ(room({{{1}, 2}, {{2}, 2}, {{3}, 1}}), Room::never);
  put(1, 10), put(1, 11), put(2, 20);
  EXPECT_EQ(room({{{1}, 9}, {{2}, 9}}), Room::now);
  EXPECT_EQ(room({{{1}, 9}, {{2}, 9}, {{3}, 1}}), Room::never);
  EXPECT_EQ(room({{{1}, 9}, {{3}, 2}}), Room::later);
  take();
  EXPECT_EQ(room({{{1}, 9}, {{3}, 2}}), Room::now);
}

// A malformed sample must not be compared with all valid samples before it.
TEST_F(ReaderCacheTest, ManyMalformedSamples_BesideValidOnes_CostEachTheirOwn) {
  constexpr int kMany = 30'000;
  std::int64_t number = 0;
  const auto store = [&](std::uint8_t value) {
    Change change;
    change.writer = writer(1);
    change.sequence_number = {++number};
    change.key_hash = KeyHash{1};
    change.payload = Payload::copy_of(Bytes{value});
    ASSERT_EQ(cache().store(change, moment()).outcome, StoreResult::stored);
  };
  for (int i = 0; i < kMany; ++i) store(1);
  for (int i = 0; i < kMany; ++i) store(2);
  auto all = read();
  std::erase_if(all, [](const auto& sample) { return sample.payload.view()[0] == 1; });
  const auto start = std::clock();
  EXPECT_EQ(cache().discard(all), static_cast<std::size_t>(kMany));
  EXPECT_LT(std::clock() - start, CLOCKS_PER_SEC / 2 * test::kSlowdown);
  EXPECT_EQ(cache().held().samples(), static_cast<std::size_t>(kMany));
  EXPECT_EQ(cache().discard(all), 0u);
}

// A call must not look at all samples that were read before.
TEST_F(ReaderCacheTest, SamplesThatAreTakenOneByOne_BesideReadOnes_CostEachTheirOwn) {
  constexpr int kMany = 30'000;
  for (int i = 0; i < kMany; ++i) put(1, 1);
  read();
  for (int i = 0; i < kMany; ++i) put(1, 2);
  const SampleQuery next{
      .states = {.sample = SampleState::not_read}, .max_samples = 1, .take = true};
  const auto start = std::clock();
  for (int i = 0; i < kMany; ++i) ASSERT_THAT(values(select(next)), ElementsAre(2));
  EXPECT_THAT(select(next), IsEmpty());
  EXPECT_LT(std::clock() - start, CLOCKS_PER_SEC * test::kSlowdown);
}

// A search for unread samples finds all of them, whatever was read, taken and inserted before.
TEST_F(ReaderCacheTest, UnreadSamples_InAnyOrder_AreFound) {
  struct Expected {
    std::int64_t stamp;
    int value;
    bool is_read = false;
  };
  for (const bool by_source : {false, true}) {
    qos.destination_order =
        by_source ? DestinationOrderKind::by_source : DestinationOrderKind::by_reception;
    made.reset();
    std::mt19937 random(by_source ? 5 : 7);
    std::vector<Expected> model;
    std::int64_t seen_until = 0;
    for (int i = 0; i < 20'000; ++i) {
      const auto dice = random() % 8;
      if (dice < 4) {
        const std::int64_t stamp = i + static_cast<std::int64_t>(random() % 20);
        const int value = static_cast<int>(random() % 256);
        put(1, static_cast<std::uint8_t>(value), {}, 1, milliseconds(stamp));
        if (by_source && stamp < seen_until) continue;
        auto at = model.end();
        while (by_source && at != model.begin() && stamp < std::prev(at)->stamp) --at;
        model.insert(at, {stamp, value});
        continue;
      }
      const bool unread_only = dice != 4, takes = dice > 5;
      const std::size_t most = 1 + random() % 3;
      std::vector<int> expected;
      for (auto at = model.begin(); at != model.end() && expected.size() < most;) {
        if (unread_only && at->is_read) {
          ++at;
          continue;
        }
        expected.push_back(at->value);
        seen_until = std::max(seen_until, at->stamp);
        at->is_read = true;
        at = takes ? model.erase(at) : std::next(at);
      }
      SampleQuery query{.max_samples = most, .take = takes};
      if (unread_only) query.states.sample = SampleState::not_read;
      ASSERT_EQ(values(select(query)), expected) << i;
    }
  }
}

// The writer's clock was an hour ahead for a moment. The writer goes on with the last timestamp,
// but its samples must not be dropped for that hour.
TEST_F(ReaderCacheTest, AClockThatWasSetBack_DoesNotSilenceSourceOrder) {
  qos.destination_order = DestinationOrderKind::by_source;
  qos.history = {HistoryKind::keep_last, 1};
  const auto later = now + std::chrono::hours(1);
  const auto store = [&](MonotonicTime wall, std::uint8_t value) {
    Change change;
    change.writer = writer(1);
    change.key_hash = KeyHash{1};
    change.source_time = Time::from(later);
    change.payload = Payload::copy_of(Bytes{value});
    return cache().store(change, {now, Time::from(wall)}).outcome;
  };
  EXPECT_EQ(store(later, 1), StoreResult::stored);
  EXPECT_THAT(values(take()), ElementsAre(1));
  EXPECT_EQ(store(now, 2), StoreResult::stored);
  EXPECT_THAT(values(take()), ElementsAre(2));
  EXPECT_EQ(store(later, 3), StoreResult::stored);
  EXPECT_EQ(store(now, 4), StoreResult::stored) << "the former one is not read yet";
  put(1, 0, kDispose);
  EXPECT_EQ(read().back().info.instance_state, InstanceState::not_alive_disposed);
}

TEST_F(ReaderCacheTest, Samples_ReadKeepsAndTakeRemoves) {
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
  EXPECT_EQ(cache().held().samples(), 0u);
  EXPECT_EQ(cache().held().all().size(), 1u);  // its writer is alive
}

TEST_F(ReaderCacheTest, AnInstance_EndsAndComesBackAsANewGeneration) {
  put(1, 10), put(1, 0, kDispose);
  auto samples = read();
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_EQ(samples[1].info.instance_state, InstanceState::not_alive_disposed);
  EXPECT_FALSE(samples[1].info.valid_data);
  EXPECT_TRUE(samples[1].is_key_only);
  EXPECT_EQ(samples[1].payload.view()[0], 1);  // this is the key
  put(1, 11);  // the sample that reported the end was read, so the end is over
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

TEST_F(ReaderCacheTest, AnInstanceWithoutWriters_SaysSoAndIsForgottenOnceTaken) {
  put(1, 10, {}, 1), put(1, 11, {}, 2), put(2, 20, {}, 2);
  EXPECT_FALSE(cache().lose_writer(writer(1), ReaderCache::WriterLoss::unmatched, now));
  EXPECT_EQ(read({.instance = InstanceState::alive}).size(), 3u);
  EXPECT_TRUE(cache().lose_writer(writer(2), ReaderCache::WriterLoss::unmatched, now));
  const auto samples = take();
  ASSERT_EQ(samples.size(), 5u);
  EXPECT_EQ(samples[0].info.instance_state, InstanceState::not_alive_no_writers);
  EXPECT_FALSE(samples[2].info.valid_data);
  EXPECT_EQ(cache().held().all().size(), 0u);
  EXPECT_EQ(cache().held().octets(), 0u);
}

TEST_F(ReaderCacheTest, DisposedAndUnregisteredAtOnce_IsDisposed) {
  put(1, 10), put(1, 0, kBoth);
  EXPECT_EQ(take().back().info.instance_state, InstanceState::not_alive_disposed);
  EXPECT_EQ(cache().held().all().size(), 0u);
  // This instance was never received.
  EXPECT_EQ(put(7, 0, kUnregister).outcome, StoreResult::dropped);
  EXPECT_EQ(cache().held().all().size(), 0u);
}

TEST_F(ReaderCacheTest, Lifespan_EndsSamplesFromTheirSourceTimeOn) {
  cache().set_writer(writer(1), 0, Duration::from(milliseconds(100)));
  put(1, 10), put(1, 11, {}, 2);
  EXPECT_EQ(put(1, 12, {}, 1, now - milliseconds(100)).outcome, StoreResult::dropped);
  put(1, 13, {}, 1, now - milliseconds(60));
  put(1, 14, {}, 1, now + std::chrono::hours(1));  // the writer's clock is ahead of ours
  EXPECT_EQ(cache().next_tick(), now + milliseconds(40));
  now += milliseconds(50);
  EXPECT_THAT(values(read()), ElementsAre(10, 11, 14));
  now += milliseconds(50);
  EXPECT_TRUE(cache().expire(now));
  EXPECT_THAT(values(take()), ElementsAre(11));
  EXPECT_EQ(cache().next_tick(), kNever);
}

TEST_F(ReaderCacheTest, Samples_ExpireInAnyOrderAndWhenTheyAreTaken) {
  cache().set_writer(writer(1), 0, Duration::from(milliseconds(100)));
  for (int i = 0; i < 10; ++i)
    put(static_cast<std::uint8_t>(i % 2), static_cast<std::uint8_t>(i), {}, 1,
        now - milliseconds(10 * (i * 7 % 10)));
  (void)select({.max_samples = 3, .take = true});
  std::size_t left = cache().held().samples();
  for (; left > 0; --left) {
    const auto next = cache().next_tick();
    ASSERT_NE(next, kNever);
    EXPECT_FALSE(cache().expire(next - std::chrono::nanoseconds(1)));
    EXPECT_TRUE(cache().expire(next));
    EXPECT_EQ(cache().held().samples(), left - 1);
  }
  EXPECT_EQ(cache().next_tick(), kNever);
}

TEST_F(ReaderCacheTest, ManyMissedDeadlines_AreReportedInTurns) {
  constexpr auto kInstances = 2 * ReaderCache::kMaxMissed;
  qos.deadline = Duration::from(milliseconds(100));
  for (std::size_t i = 0; i < kInstances; ++i) {
    Change change;
    change.writer = writer(1);
    change.key_hash = KeyHash{static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i >> 8)};
    change.payload = Payload::copy_of(Bytes(1));
    cache().store(change, moment());
  }
  std::set<InstanceHandle> missed;
  const auto check = [&] { cache().expire_deadlines(now, [&](auto i) { missed.insert(i); }); };
  now += milliseconds(100);
  check();
  check();
  EXPECT_EQ(missed.size(), ReaderCache::kMaxMissed);
  EXPECT_EQ(cache().next_tick(), now + ReaderCache::kMissedPause);
  now += ReaderCache::kMissedPause;
  check();
  EXPECT_EQ(missed.size(), kInstances);
  EXPECT_EQ(cache().next_tick(), now + milliseconds(99));
}

TEST_F(ReaderCacheTest, Deadlines_AreOfEachInstance) {
  qos.deadline = Duration::from(milliseconds(100));
  std::vector<InstanceHandle> missed;
  const auto check = [&] { cache().expire_deadlines(now, [&](auto i) { missed.push_back(i); }); };
  put(1, 10);
  now += milliseconds(60);
  put(2, 20);
  now += milliseconds(60);
  check();
  const auto one = cache().lookup(KeyHash{1}), two = cache().lookup(KeyHash{2});
  EXPECT_THAT(missed, ElementsAre(one));
  EXPECT_EQ(cache().next_tick(), now + milliseconds(40));
  put(2, 0, kDispose);  // nothing more is expected for this instance
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

TEST_F(ReaderCacheTest, ManySamplesThroughAFewInstances_GrowNothing) {
  for (int i = 0; i < 20'000; ++i) {
    put(static_cast<std::uint8_t>(i % 7), 1);
    if (i % 50 == 0) take();
  }
  take();
  EXPECT_EQ(cache().held().octets(), 7u);  // those of the keys
  EXPECT_FALSE(cache().any({}));
}

}  // namespace
}  // namespace ddssec::rtps
