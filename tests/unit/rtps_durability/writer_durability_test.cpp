// The stores of a participant, and the stream of a writer in one of them.
#include "rtps/dcps/writer_durability.hpp"

#include "rtps/durability/durable_stores.hpp"
#include "tests/unit/rtps_durability/store_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;
using namespace std::chrono_literals;

constexpr std::size_t kMebibyte = std::size_t{1} << 20;

struct WriterDurabilityTest : StoreTest {
  test::RecordedEvents events;
  DurableStores stores{events};
  const Guid writer{GuidPrefix{{1, 2, 3}}, kWriter};
};

TEST_F(WriterDurabilityTest, NotOpened_NothingHappens) {
  WriterDurability durability;
  std::mutex mutex;
  std::unique_lock lock(mutex);
  auto change = sample(1);
  durability.append(change, writer, {1}, at(0));
  EXPECT_FALSE(durability.is_open());
  EXPECT_EQ(change.original.number.value, 0);
  EXPECT_TRUE(durability.wait_for_room(lock, 0ns));
  EXPECT_TRUE(durability.flush(0ns));
}

TEST_F(WriterDurabilityTest, NextWriter_GetsWhatTheOneBeforeLeft_WithItsName) {
  ASSERT_TRUE(stores.open_file(path, kMebibyte, false, {}));
  auto& store = **stores.of(DurabilityKind::persistent);
  {
    WriterDurability first;
    EXPECT_TRUE(first.open(store, kMap, keep_all(), at(1000))->history.empty());
    auto change = sample(7);
    first.append(change, writer, {41}, at(0));
    EXPECT_EQ(change.original.number.value, 0);  // messages name no other writer
    ASSERT_TRUE(first.flush(10s));
    WriterDurability beside_it;
    EXPECT_TRUE(beside_it.open(store, kMap, keep_all(), at(1000))->history.empty());
  }
  WriterDurability next;
  const auto opened = next.open(store, kMap, keep_all(), at(1000));
  ASSERT_TRUE(opened);
  ASSERT_EQ(numbers(opened->history), std::vector<std::uint32_t>{7});
  EXPECT_EQ(opened->history.front().original.writer, writer);
}

// Otherwise the sample would not fit, and would be left out for good.
TEST_F(WriterDurabilityTest, Append_MakesRoomOfWhatHasExpired) {
  auto& store = **stores.of(DurabilityKind::transient);
  auto service = keep_all();
  service.limits.max_samples = 1;
  WriterDurability durability;
  ASSERT_TRUE(durability.open(store, kMap, service, at(0), Duration{{10, 0}}));
  for (const auto i : {1, 12}) {
    auto change = sample(static_cast<std::uint32_t>(i));
    durability.append(change, writer, {i}, at(i));
  }
  EXPECT_EQ(store.left_out(), 0u);
}

TEST_F(WriterDurabilityTest, StoreWithRoom_IsNotWaitedFor) {
  WriterDurability durability;
  ASSERT_TRUE(durability.open(**stores.of(DurabilityKind::transient), kMap, keep_all(), at(1000)));
  std::mutex mutex;
  std::unique_lock lock(mutex);
  EXPECT_TRUE(durability.wait_for_room(lock, 0ns));
  EXPECT_TRUE(lock.owns_lock());
}

TEST_F(WriterDurabilityTest, StoresOf_KindsWithAFile_AreTwo) {
  ASSERT_TRUE(stores.open_file(path, kMebibyte, false, {}));
  auto* persistent = *stores.of(DurabilityKind::persistent);
  auto* transient = *stores.of(DurabilityKind::transient);
  EXPECT_NE(persistent, transient);
  EXPECT_EQ(*stores.of(DurabilityKind::transient), transient);
  EXPECT_TRUE(events.all.empty());
}

TEST_F(WriterDurabilityTest, StoresOf_PersistentWithoutAFile_IsMemoryAndAWarning) {
  const auto store = stores.of(DurabilityKind::persistent);
  ASSERT_TRUE(store);
  EXPECT_EQ(*store, *stores.of(DurabilityKind::transient));
  ASSERT_EQ(events.all.size(), 1u);
  EXPECT_EQ(events.all.front().error.code(), Code::rtps_store_unusable);
}

}  // namespace
}  // namespace ddssec::rtps
