// TIME_BASED_FILTER, when an instance or its writer ends while a sample is held back (DDS 1.4,
// 2.2.3.12: a reliable reader gets the last sample in the end).
#include <optional>

#include <gmock/gmock.h>

#include "rtps/dcps/reader_cache.hpp"

namespace ddssec::rtps {
namespace {

using std::chrono::seconds;
using ::testing::ElementsAre;
using StoreResult = ReaderCache::StoreResult;

constexpr int kEnd = -1;  // stands for a sample without data

struct TimeBasedFilterEnd : ::testing::Test {
  TimeBasedFilterEnd() {
    cache->set_writer(writer(1), 0, kDurationInfinite, identity(1));
    cache->set_writer(writer(2), 0, kDurationInfinite, identity(2));
  }
  static GuidPrefix identity(std::uint8_t number) { return GuidPrefix::from(Bytes(12, number)); }
  static Guid writer(std::uint8_t number) { return {identity(number), EntityId{{0, 0, 1, 2}}}; }
  static Qos qos() {
    Qos all;
    all.reliability.kind = ReliabilityKind::reliable;
    all.history.kind = HistoryKind::keep_all;
    all.resource_limits.max_samples = 2;
    all.time_based_filter = Duration::from(seconds(3));
    return all;
  }
  Moment moment() const { return {now, Time::from(now)}; }
  StoreResult put(int value, std::uint8_t from = 1) {
    Change change;
    change.writer = writer(from);
    change.key_hash = KeyHash{1};
    change.source_time = Time::from(now);
    if (value == kEnd)
      change.status.unregistered = true;
    else
      change.payload = Payload::copy_of(Bytes(1000, static_cast<std::uint8_t>(value)));
    return cache->store(change, moment()).outcome;
  }
  std::vector<int> take() {
    std::vector<OctetSample> samples;
    cache->select({.take = true}, moment(), samples);
    std::vector<int> out;
    for (const auto& sample : samples)
      out.push_back(sample.info.valid_data ? sample.payload.view()[0] : kEnd);
    return out;
  }
  std::vector<int> taken_after(seconds time) {
    now += time;
    cache->release(moment());
    return take();
  }

  StoreResult put_of_time(int value, int seconds, std::uint8_t from, bool disposes = false) {
    Change change;
    change.writer = writer(from);
    change.key_hash = KeyHash{1};
    change.source_time = Time{{seconds, 0}};
    change.status.disposed = disposes;
    change.payload = Payload::copy_of(Bytes{static_cast<std::uint8_t>(value)});
    return cache->store(change, moment()).outcome;
  }
  void begin(const Qos& other) {
    cache.emplace(other);
    cache->set_writer(writer(1), 1, kDurationInfinite, identity(1));
    cache->set_writer(writer(2), 10, kDurationInfinite, identity(2));
  }

  std::optional<ReaderCache> cache{std::in_place, qos()};
  MonotonicTime now = seconds(100);
};

TEST_F(TimeBasedFilterEnd, Unregister_LastSampleComesBeforeIt) {
  ASSERT_EQ(put(10), StoreResult::stored);
  ASSERT_EQ(put(11), StoreResult::dropped);  // it is held back
  EXPECT_EQ(put(kEnd), StoreResult::stored);
  EXPECT_THAT(take(), ElementsAre(10, 11, kEnd));
  EXPECT_THAT(taken_after(seconds(10)), ElementsAre());
  EXPECT_EQ(cache->held().octets(), 0U);
}

TEST_F(TimeBasedFilterEnd, WriterLeaves_LastSampleComesBeforeTheEnd) {
  ASSERT_EQ(put(10), StoreResult::stored);
  ASSERT_EQ(put(11), StoreResult::dropped);
  EXPECT_TRUE(cache->lose_writer(writer(1), ReaderCache::WriterLoss::unmatched, now));
  EXPECT_THAT(take(), ElementsAre(10, 11, kEnd));
  EXPECT_EQ(cache->held().octets(), 0U);
}

TEST_F(TimeBasedFilterEnd, UnregisterInAFullReader_IsRepeatedUntilThereIsRoom) {
  ASSERT_EQ(put(10), StoreResult::stored);
  now += seconds(3);
  ASSERT_EQ(put(11), StoreResult::stored);
  ASSERT_EQ(put(12), StoreResult::dropped);
  EXPECT_EQ(put(kEnd), StoreResult::rejected);
  EXPECT_THAT(take(), ElementsAre(10, 11));
  EXPECT_EQ(put(kEnd), StoreResult::stored);
  EXPECT_THAT(take(), ElementsAre(12, kEnd));
}

TEST_F(TimeBasedFilterEnd, InstanceThatReturns_IsNotForgottenBeforeItsSample) {
  ASSERT_EQ(put(10), StoreResult::stored);
  ASSERT_EQ(put(kEnd), StoreResult::stored);
  ASSERT_EQ(put(11), StoreResult::dropped);
  EXPECT_THAT(take(), ElementsAre(10, kEnd));
  EXPECT_THAT(taken_after(seconds(3)), ElementsAre(11));
}

TEST_F(TimeBasedFilterEnd, InstanceThatReturns_CountsNothingWhenItHasEnded) {
  for (int round = 0; round < 100; ++round) {
    ASSERT_EQ(put(10), StoreResult::stored) << round;
    ASSERT_EQ(put(kEnd), StoreResult::stored);
    ASSERT_EQ(put(11), StoreResult::dropped);
    EXPECT_THAT(take(), ElementsAre(10, kEnd));
    EXPECT_THAT(taken_after(seconds(3)), ElementsAre(11));
    ASSERT_EQ(put(kEnd), StoreResult::stored);
    EXPECT_THAT(take(), ElementsAre(kEnd));
    EXPECT_EQ(cache->held().octets(), 0U);
  }
}

TEST_F(TimeBasedFilterEnd, AnotherWriterLeaves_SampleIsKept) {
  ASSERT_EQ(put(10, 1), StoreResult::stored);
  ASSERT_EQ(put(20, 2), StoreResult::dropped);
  EXPECT_EQ(put(kEnd, 1), StoreResult::stored);
  EXPECT_THAT(take(), ElementsAre(10));
  EXPECT_FALSE(cache->lose_writer(writer(1), ReaderCache::WriterLoss::unmatched, now));
  EXPECT_THAT(taken_after(seconds(3)), ElementsAre(20));
}

TEST_F(TimeBasedFilterEnd, OneOfTwoUnregisters_ItsLastSampleComesAndTheInstanceLives) {
  ASSERT_EQ(put(20, 2), StoreResult::stored);
  ASSERT_EQ(put(10, 1), StoreResult::dropped);
  EXPECT_EQ(put(kEnd, 1), StoreResult::stored);
  EXPECT_THAT(take(), ElementsAre(20, 10));
}

// ---- samples that may replace the one that is held back

TEST_F(TimeBasedFilterEnd, Exclusive_WeakerWriterReplacesNothing) {
  auto exclusive = qos();
  exclusive.ownership = OwnershipKind::exclusive;
  begin(exclusive);
  ASSERT_EQ(put(1, 1), StoreResult::stored);
  ASSERT_EQ(put(2, 2), StoreResult::dropped);  // it is held back
  ASSERT_EQ(put(3, 1), StoreResult::dropped);  // the second writer owns the instance
  EXPECT_THAT(take(), ElementsAre(1));
  EXPECT_THAT(taken_after(seconds(3)), ElementsAre(2));
}

TEST_F(TimeBasedFilterEnd, SourceOrder_OlderSampleOrDisposeReplacesNothing) {
  auto by_source = qos();
  by_source.destination_order = DestinationOrderKind::by_source;
  begin(by_source);
  ASSERT_EQ(put_of_time(1, 10, 1), StoreResult::stored);
  ASSERT_EQ(put_of_time(2, 20, 2), StoreResult::dropped);
  ASSERT_EQ(put_of_time(3, 12, 1), StoreResult::dropped);
  ASSERT_EQ(put_of_time(0, 15, 1, true), StoreResult::dropped);
  EXPECT_THAT(take(), ElementsAre(1));
  EXPECT_THAT(taken_after(seconds(3)), ElementsAre(2));
}

// A writer whose clock is slow must not remain one of the instance's writers.
TEST_F(TimeBasedFilterEnd, SourceOrder_UnregisterOfALateClockStillCounts) {
  auto by_source = qos();
  by_source.destination_order = DestinationOrderKind::by_source;
  by_source.time_based_filter = kDurationZero;
  begin(by_source);
  const auto unregister = [&](int time, std::uint8_t from) {
    Change change;
    change.writer = writer(from);
    change.key_hash = KeyHash{1};
    change.source_time = Time{{time, 0}};
    change.status.unregistered = true;
    return cache->store(change, moment()).outcome;
  };
  ASSERT_EQ(put_of_time(1, 9, 1), StoreResult::stored);
  ASSERT_EQ(put_of_time(2, 12, 2), StoreResult::stored);
  EXPECT_EQ(unregister(10, 1), StoreResult::dropped);
  EXPECT_THAT(take(), ElementsAre(1, 2));
  EXPECT_EQ(unregister(11, 2), StoreResult::stored);
  EXPECT_THAT(take(), ElementsAre(kEnd));
}

}  // namespace
}  // namespace ddssec::rtps
