// The owner of an instance.
#include "rtps/dcps/instance_writers.hpp"

#include "tests/unit/rtps/reader_cache_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

using ReaderCacheTest = Cache;

TEST_F(ReaderCacheTest, TheStrongestWriter_OwnsAnInstance) {
  qos.ownership = OwnershipKind::exclusive;
  cache().set_writer(writer(1), 5, kDurationInfinite);
  cache().set_writer(writer(2), 10, kDurationInfinite);
  put(1, 10, {}, 1);
  put(1, 20, {}, 2);
  EXPECT_EQ(put(1, 11, {}, 1).outcome, StoreResult::dropped);
  EXPECT_EQ(put(1, 0, kDispose, 1).outcome, StoreResult::dropped);
  put(2, 12, {}, 1);  // no stronger writer writes this instance
  EXPECT_THAT(values(take()), ElementsAre(10, 20, 12));
  cache().set_writer(writer(1), 11, kDurationInfinite);
  put(1, 13, {}, 1);
  EXPECT_EQ(put(1, 21, {}, 2).outcome, StoreResult::dropped);
  EXPECT_THAT(values(take()), ElementsAre(13));
}

TEST_F(ReaderCacheTest, EquallyStrongWriters_AreDecidedByTheirGuid) {
  qos.ownership = OwnershipKind::exclusive;
  put(1, 20, {}, 2), put(1, 10, {}, 1), put(1, 21, {}, 2);
  EXPECT_THAT(values(take()), ElementsAre(20, 10));
}

TEST_F(ReaderCacheTest, Ownership_PassesOnWhenItsOwnerGoesUnregistersOrIsLate) {
  qos.ownership = OwnershipKind::exclusive;
  qos.deadline = Duration::from(milliseconds(100));
  cache().set_writer(writer(1), 1, kDurationInfinite);
  cache().set_writer(writer(2), 2, kDurationInfinite);
  const auto weak_is_heard = [&] {
    const auto outcome = put(1, 10, {}, 1).outcome;
    put(1, 20, {}, 2);
    return outcome == StoreResult::stored;
  };
  EXPECT_TRUE(weak_is_heard());
  EXPECT_FALSE(weak_is_heard());
  cache().lose_writer(writer(2), ReaderCache::WriterLoss::not_alive, now);
  EXPECT_TRUE(weak_is_heard());
  put(1, 0, kUnregister, 2);
  EXPECT_TRUE(weak_is_heard());
  now += milliseconds(150);
  cache().expire_deadlines(now, [](InstanceHandle) {});
  EXPECT_TRUE(weak_is_heard());
  EXPECT_THAT(take({.instance = kNotAlive}), IsEmpty());  // a weaker writer existed all the time
}

}  // namespace
}  // namespace ddssec::rtps
