// A store on a small disk of its own.
#include "rtps/durability/store_disk.hpp"

#include <sched.h>
#include <sys/mount.h>
#include <sys/wait.h>

#include "tests/unit/rtps_durability/store_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr int kNoDisk = 77;

struct StoreDiskTest : StoreTest {
  // Runs it in a process whose `folder` is a disk of that many megabytes. Fails if an expectation
  // fails there.
  template <class Run>
  void on_disk(int megabytes, Run run) {
    const auto child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      const auto size = "mode=700,size=" + std::to_string(megabytes) + "m";
      const bool has_disk =
          ::unshare(CLONE_NEWNS) == 0 &&
          ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
          ::mount("none", folder.c_str(), "tmpfs", MS_NOSUID | MS_NODEV, size.c_str()) == 0;
      if (has_disk) run();
      std::fflush(nullptr);
      ::_exit(!has_disk ? kNoDisk : HasFailure() ? 1 : 0);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    if (WIFEXITED(status) && WEXITSTATUS(status) == kNoDisk)
      GTEST_SKIP() << "this system lets no process mount a disk of its own";
    EXPECT_TRUE(WIFEXITED(status)) << status;
    EXPECT_EQ(WEXITSTATUS(status), 0);
  }
  // Commits samples, each of an instance of its own, until one fails.
  static std::uint32_t fill(IndexedStore& store, StreamId id, std::size_t octets, Time now) {
    for (std::uint32_t number = 0; number < 20'000; ++number) {
      auto change = sample(number, 20'000);
      change.source_time = now;
      change.key_hash->fill(0);
      std::memcpy(change.key_hash->data(), &number, sizeof number);
      change.payload = Payload::copy_of(Bytes(octets, static_cast<std::uint8_t>(number)));
      StoredChange stored{.stream = id, .change = change, .lifespan = Duration{{6, 0}}};
      if (!store.commit({stored}, now)) return number;
    }
    return 20'000;
  }
};

// The removal of expired samples must find room, or nothing would be stored any more, even after a
// restart.
TEST_F(StoreDiskTest, FullDisk_OnceAllHasExpired_HasRoomAgain) {
  on_disk(8, [&] {
    auto store = IndexedStore::open(path);
    ASSERT_OK(store);
    const auto id = store->stream(kMap, keep_all());
    ASSERT_OK(id);
    const auto count = fill(*store, *id, 2'000, seconds(1000));
    EXPECT_GT(count, 500U);
    EXPECT_LT(count, 4'000U);
    EXPECT_FALSE(store->commit({}, seconds(1000))) << "the sample that failed waits";
    store->pending.clear();
    ASSERT_OK(store->clean_up(*id, seconds(1010)));
    EXPECT_GE(fill(*store, *id, 2'000, seconds(1010)), count * 9 / 10);
  });
}

TEST_F(StoreDiskTest, FullDisk_WhatWasStored_IsReadAndExpiresAtTheNextStart) {
  on_disk(8, [&] {
    std::uint32_t count = 0;
    {
      auto store = IndexedStore::open(path);
      ASSERT_OK(store);
      count = fill(*store, *store->stream(kMap, keep_all()), 20'000, seconds(1000));
    }
    {
      auto store = SampleStore::open(path, SampleStore::kDefaultOctets, seconds(1001));
      ASSERT_OK(store);
      EXPECT_EQ(store->load(*store->stream(kMap))->changes.size(), count);
    }
    auto store = SampleStore::open(path, SampleStore::kDefaultOctets, seconds(1010));
    ASSERT_OK(store);
    EXPECT_TRUE(store->load(*store->stream(kMap))->changes.empty());
  });
}

// The log alone must not fill the disk if KEEP_LAST keeps only a few kilobytes.
TEST_F(StoreDiskTest, SmallDisk_FewSamplesThatReplaceOthers_AreStoredForever) {
  on_disk(2, [&] {
    auto store = IndexedStore::open(path);
    ASSERT_OK(store);
    const auto id = *store->stream(kMap, keep_last(1));
    for (std::uint32_t number = 0; number < 2'000; ++number)
      ASSERT_OK(store->commit({{.stream = id, .change = sample(number, 20)}}, seconds(1)));
  });
}

TEST_F(StoreDiskTest, RoomOfTheStore_IsWithinThatOfTheDisk) {
  on_disk(8, [&] {
    auto store = IndexedStore::open(path);
    ASSERT_OK(store);
    const auto room = store->store.room();
    ASSERT_OK(room);
    EXPECT_LT(*room, std::size_t{8} << 20);
    EXPECT_GT(*room, std::size_t{6} << 20);
  });
}

TEST_F(StoreDiskTest, FileThatIsNotThere_HasAllRoom) {
  EXPECT_GT(room_on_disk(folder / "nothing", 0), std::size_t{1} << 40);
}

}  // namespace
}  // namespace ddssec::rtps
