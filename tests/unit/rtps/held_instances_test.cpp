// Instances that end, and what is kept of them.
#include "rtps/dcps/held_instances.hpp"

#include "tests/unit/rtps/reader_cache_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

using ReaderCacheTest = Cache;

TEST_F(ReaderCacheTest, AnEndedInstance_MakesRoomForANewOne) {
  qos.resource_limits.max_instances = 2;
  put(1, 10), put(2, 20), put(1, 0, kDispose);
  EXPECT_EQ(put(3, 30).reason, Reason::by_instances_limit);
  take();
  EXPECT_EQ(put(3, 30).outcome, StoreResult::stored);
  EXPECT_TRUE(cache().lookup(KeyHash{1}).is_nil());
}

TEST_F(ReaderCacheTest, TheKey_IsKnownWhileTheInstanceIs) {
  put(5, 50);
  const auto instance = cache().lookup(KeyHash{5});
  ASSERT_NE(cache().key_value(instance), nullptr);
  EXPECT_EQ(cache().key_value(instance)->view()[0], 5);
  EXPECT_EQ(cache().key_value({99}), nullptr);
}

TEST_F(ReaderCacheTest, EndedInstances_ArePurgedAfterTheirDelay) {
  qos.reader_data_lifecycle = {Duration::from(milliseconds(100)), Duration::from(milliseconds(50))};
  put(1, 10), put(2, 20), put(3, 30);
  put(1, 1, kDispose), put(2, 2, kUnregister);
  EXPECT_EQ(cache().next_tick(), now + milliseconds(50));
  now += milliseconds(50);
  EXPECT_TRUE(cache().expire(now));
  EXPECT_THAT(values(read()), ElementsAre(20, 2, 30));
  put(2, 21);  // the instance comes back in time
  now += milliseconds(100);
  EXPECT_FALSE(cache().expire(now));
  EXPECT_EQ(cache().next_tick(), kNever);
  cache().lose_writer(writer(1), ReaderCache::WriterLoss::unmatched, now);
  now += milliseconds(100);
  EXPECT_TRUE(cache().expire(now));
  EXPECT_THAT(read(), IsEmpty());
  EXPECT_EQ(cache().held().all().size(), 0u);
  EXPECT_EQ(cache().held().octets(), 0u);
  EXPECT_FALSE(cache().any({}));
}

TEST_F(ReaderCacheTest, ADisposedInstanceThatLosesItsWriters_IsPurgedAsDisposed) {
  qos.reader_data_lifecycle = {Duration::from(milliseconds(10)), Duration::from(milliseconds(50))};
  put(1, 10), put(1, 1, kDispose);
  cache().lose_writer(writer(1), ReaderCache::WriterLoss::unmatched, now);
  now += milliseconds(20);
  EXPECT_FALSE(cache().expire(now));
  qos.reader_data_lifecycle = {};
  cache().set_lifecycle(qos.reader_data_lifecycle);  // counts for later ends
  now += milliseconds(30);
  EXPECT_TRUE(cache().expire(now));
  EXPECT_EQ(cache().held().all().size(), 0u);
}

}  // namespace
}  // namespace ddssec::rtps
