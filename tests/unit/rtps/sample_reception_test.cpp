// Samples that replace others, are rejected, or come late.
#include "rtps/dcps/sample_reception.hpp"

#include "tests/unit/rtps/reader_cache_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

using ReaderCacheTest = Cache;

TEST_F(ReaderCacheTest, KeepLast_ReplacesTheOldestOfItsInstance) {
  qos.history = {HistoryKind::keep_last, 2};
  for (std::uint8_t i = 0; i < 5; ++i) put(1, i), put(2, i);
  EXPECT_THAT(values(take()), ElementsAre(3, 4, 3, 4));
}

TEST_F(ReaderCacheTest, EachLimit_RejectsByItsNameAndChangesNothing) {
  qos.resource_limits = {.max_samples = 3, .max_instances = 2, .max_samples_per_instance = 2};
  put(1, 10), put(1, 11);
  EXPECT_EQ(put(1, 12).reason, Reason::by_samples_per_instance_limit);
  put(2, 20);
  const auto rejected = put(2, 21);
  EXPECT_EQ(rejected.reason, Reason::by_samples_limit);
  EXPECT_EQ(rejected.instance, cache().lookup(KeyHash{2}));
  EXPECT_EQ(put(3, 30).reason, Reason::by_instances_limit);
  EXPECT_EQ(cache().held().samples(), 3u);
  EXPECT_THAT(values(take()), ElementsAre(10, 11, 20));
  EXPECT_EQ(put(2, 21).outcome, StoreResult::stored);
  // A limit of samples does not apply to the report that an instance ended.
  put(1, 12), put(1, 13);
  EXPECT_EQ(put(1, 0, kDispose).outcome, StoreResult::stored);
}

TEST_F(ReaderCacheTest, SourceOrder_NeverGoesBack) {
  qos.destination_order = DestinationOrderKind::by_source;
  put(1, 12, {}, 1, milliseconds(2)), put(1, 11, {}, 2, milliseconds(1));
  EXPECT_THAT(values(take()), ElementsAre(11, 12));
  EXPECT_EQ(put(1, 10, {}, 2, milliseconds(1)).outcome, StoreResult::dropped);
  put(1, 15, {}, 1, milliseconds(5));
  EXPECT_EQ(put(1, 0, kDispose, 2, milliseconds(4)).outcome, StoreResult::dropped);
  put(1, 14, {}, 2, milliseconds(4));
  EXPECT_THAT(values(take()), ElementsAre(14, 15));
}

// Otherwise one sample from the far future would silence all other writers of the instance.
TEST_F(ReaderCacheTest, SourceOrder_ATimeFarAheadCountsAsArrival) {
  qos.destination_order = DestinationOrderKind::by_source;
  constexpr auto kMax = ReaderCache::kMaxAhead;
  put(1, 10, {}, 1, now + std::chrono::hours(100'000));
  EXPECT_EQ(cache().times_ahead(), 1u);
  EXPECT_EQ(take().at(0).info.source_timestamp, Time::from(now));
  now += milliseconds(1);
  EXPECT_EQ(put(1, 11, {}, 2).outcome, StoreResult::stored);
  EXPECT_EQ(put(1, 12, {}, 1, now + kMax).outcome, StoreResult::stored) << "as far as is allowed";
  EXPECT_EQ(cache().times_ahead(), 1u);
  EXPECT_EQ(put(1, 0, kDispose, 2, now + kMax + milliseconds(1)).outcome, StoreResult::dropped)
      << "it ends nothing that was written later";
  EXPECT_EQ(cache().times_ahead(), 2u);
  EXPECT_THAT(values(take()), ElementsAre(11, 12));
  now += kMax + milliseconds(1);
  EXPECT_EQ(put(1, 13, {}, 2).outcome, StoreResult::stored);
}

TEST_F(ReaderCacheTest, SourceOrder_AFullHistoryKeepsTheNewest) {
  qos.destination_order = DestinationOrderKind::by_source;
  qos.history = {HistoryKind::keep_last, 2};
  put(1, 12, {}, 1, milliseconds(2)), put(1, 13, {}, 1, milliseconds(3));
  EXPECT_EQ(put(1, 11, {}, 2, milliseconds(1)).outcome, StoreResult::dropped);
  put(1, 14, {}, 2, milliseconds(4));
  EXPECT_THAT(values(take()), ElementsAre(13, 14));
}

}  // namespace
}  // namespace ddssec::rtps
