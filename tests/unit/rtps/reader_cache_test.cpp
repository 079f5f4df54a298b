// What a reader holds, by itself: states, generations, ranks, limits, ownership, time.
#include "tests/unit/rtps/reader_cache_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;
using ReaderCacheTest = Cache;

// Before, the instance ended with a keeper that had sent its sample first.
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

// A clock that was an hour ahead for a moment: its writer goes on with the last timestamp, and all
// samples were dropped for that hour.
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
  EXPECT_EQ(store(later, 1), Outcome::stored);
  EXPECT_THAT(values(take()), ElementsAre(1));
  EXPECT_EQ(store(now, 2), Outcome::stored);
  EXPECT_THAT(values(take()), ElementsAre(2));
  EXPECT_EQ(store(later, 3), Outcome::stored);
  EXPECT_EQ(store(now, 4), Outcome::stored) << "the former one is not read yet";
  put(1, 0, kDispose);
  EXPECT_EQ(read().back().info.instance_state, InstanceState::not_alive_disposed);
}

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
  constexpr auto kMax = ReaderCache::kMaxAhead;
  put(1, 10, {}, 1, now + std::chrono::hours(100'000));
  EXPECT_EQ(cache().times_ahead(), 1u);
  EXPECT_EQ(take().at(0).info.source_timestamp, Time::from(now));
  now += milliseconds(1);
  EXPECT_EQ(put(1, 11, {}, 2).outcome, Outcome::stored);
  EXPECT_EQ(put(1, 12, {}, 1, now + kMax).outcome, Outcome::stored) << "as far as is allowed";
  EXPECT_EQ(cache().times_ahead(), 1u);
  EXPECT_EQ(put(1, 0, kDispose, 2, now + kMax + milliseconds(1)).outcome, Outcome::dropped)
      << "it ends nothing that was written later";
  EXPECT_EQ(cache().times_ahead(), 2u);
  EXPECT_THAT(values(take()), ElementsAre(11, 12));
  now += kMax + milliseconds(1);
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
