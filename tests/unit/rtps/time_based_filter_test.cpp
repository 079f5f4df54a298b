// TIME_BASED_FILTER in a reader that is full: samples that were held back are offered again, at a
// bounded rate.
#include <gmock/gmock.h>

#include "rtps/dcps/reader_cache.hpp"

namespace ddssec::rtps {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::ElementsAre;
using StoreResult = ReaderCache::StoreResult;

struct TimeBasedFilter : ::testing::Test {
  Qos qos = [] {
    Qos all;
    all.reliability.kind = ReliabilityKind::reliable;
    all.history.kind = HistoryKind::keep_all;
    all.resource_limits.max_samples = 1;
    all.time_based_filter = Duration::from(seconds(3));
    return all;
  }();
  ReaderCache cache{qos};
  MonotonicTime now = seconds(100);

  Moment moment() const { return {now, Time::from(now)}; }
  StoreResult put(std::uint8_t value) {
    Change change;
    change.writer = {GuidPrefix::from(Bytes(12, 1)), EntityId{{0, 0, 1, 2}}};
    change.key_hash = KeyHash{1};
    change.source_time = Time::from(now);
    change.payload = Payload::copy_of(Bytes{value});
    return cache.store(change, moment()).outcome;
  }
  std::vector<int> take() {
    std::vector<OctetSample> samples;
    cache.select({.take = true}, moment(), samples);
    std::vector<int> out;
    for (const auto& sample : samples) out.push_back(sample.payload.view()[0]);
    return out;
  }
};

TEST_F(TimeBasedFilter, SetToZeroInAFullReader_ReleaseEndsAndKeepsTheSample) {
  ASSERT_EQ(put(10), StoreResult::stored);
  ASSERT_EQ(put(11), StoreResult::dropped);  // it is held back
  cache.set_minimum_separation({});
  EXPECT_LE(cache.next_tick(), now);
  EXPECT_FALSE(cache.release(moment()));
  EXPECT_GE(cache.next_tick(), now + milliseconds(1));
  EXPECT_LE(cache.next_tick(), now + milliseconds(100));
  EXPECT_THAT(take(), ElementsAre(10));
  now = cache.next_tick();
  EXPECT_TRUE(cache.release(moment()));
  EXPECT_THAT(take(), ElementsAre(11));
  EXPECT_EQ(cache.next_tick(), kNever);
}

// Otherwise each take() would make the reader compute the digest of a refused sample of 66 MB
// again.
TEST_F(TimeBasedFilter, RefusedInTheQuietTime_IsRefusedAgainAtOnceUntilThereIsRoom) {
  const Guid writer{GuidPrefix::from(Bytes(12, 1)), EntityId{{0, 0, 1, 2}}};
  cache.set_writer(writer, 0, Duration::from(seconds(2)), writer.prefix);
  ASSERT_EQ(put(10), StoreResult::stored);
  Change large;
  large.writer = writer;
  large.key_hash = KeyHash{1};
  large.source_time = Time::from(now);
  large.payload = Payload::uninitialized(HeldInstances::kMaxOctets + 1);
  ASSERT_EQ(cache.store(large, moment()).outcome, StoreResult::rejected);
  const auto again = cache.rejects_again(large, moment());
  ASSERT_TRUE(again);
  EXPECT_EQ(again->reason, SampleRejectedReason::by_samples_limit);
  EXPECT_TRUE(again->crowded);
  now += seconds(2);
  EXPECT_FALSE(cache.rejects_again(large, moment())) << "its LIFESPAN has ended";
  large.source_time = Time::from(now);
  large.payload = Payload::copy_of(Bytes{12});
  EXPECT_FALSE(cache.rejects_again(large, moment())) << "it can be held back now";
}

TEST_F(TimeBasedFilter, VeryShortInAFullReader_IsOfferedAtABoundedRate) {
  ASSERT_EQ(put(10), StoreResult::stored);
  ASSERT_EQ(put(11), StoreResult::dropped);
  cache.set_minimum_separation(Duration::from(std::chrono::nanoseconds(1)));
  int turns = 0;
  for (const auto end = now + seconds(1); now < end; ++turns) {
    ASSERT_FALSE(cache.release(moment()));
    now = std::max(cache.next_tick(), now + std::chrono::nanoseconds(1));
    ASSERT_LT(turns, 1000);
  }
  EXPECT_THAT(take(), ElementsAre(10));
  now += seconds(1);
  EXPECT_TRUE(cache.release(moment()));
  EXPECT_THAT(take(), ElementsAre(11));
}

// Without a filter, a reliable reader loses nothing and does not go back in time.
TEST_F(TimeBasedFilter, SetToZeroInAFullReader_NewSamplesAreRejectedAndReplaceTheOneHeldBack) {
  ASSERT_EQ(put(10), StoreResult::stored);
  ASSERT_EQ(put(11), StoreResult::dropped);
  cache.set_minimum_separation({});
  EXPECT_FALSE(cache.release(moment()));
  EXPECT_EQ(put(12), StoreResult::rejected);
  EXPECT_THAT(take(), ElementsAre(10));
  EXPECT_EQ(put(12), StoreResult::stored);
  EXPECT_THAT(take(), ElementsAre(12));
  now += seconds(1);
  EXPECT_FALSE(cache.release(moment()));
  EXPECT_THAT(take(), ElementsAre());
}

}  // namespace
}  // namespace ddssec::rtps
