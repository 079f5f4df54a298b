#include <cerrno>
#include <csignal>
#include <cstring>
#include <sys/resource.h>

#include "tests/unit/rtps_durability/store_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;
using namespace std::chrono_literals;

struct DurableStoreTest : StoreTest {
  test::RecordedEvents events;
  std::unique_ptr<DurableStore> open() {
    auto store = DurableStore::open(path, events);
    EXPECT_TRUE(store) << store.error().to_sentence();
    return *std::move(store);
  }
};

TEST_F(DurableStoreTest, WhatFlushWaitedFor_IsThere) {
  {
    auto store = open();
    const auto stream = *store->open_stream(kMap, keep_all(), at(1000));
    EXPECT_TRUE(stream.history.empty());
    for (std::uint32_t i = 0; i < 1000; ++i) store->append(stream.id, sample(i), at(0));
    ASSERT_TRUE(store->flush(10s));
    EXPECT_LT(store->groups(), 1000u);
  }
  EXPECT_EQ(open()->open_stream(kMap, keep_all(), at(1000))->history.size(), 1000u);
}

TEST_F(DurableStoreTest, ANextWriter_GetsWhatTheOneBeforeLeft) {
  auto store = open();
  const auto first = *store->open_stream(kMap, keep_all(), at(1000));
  const auto alike = *store->open_stream(kMap, keep_all(), at(1000));
  EXPECT_NE(first.id, alike.id);
  store->append(first.id, sample(1), at(0));
  store->append(alike.id, sample(2), at(0));
  store->close_stream(first.id);
  const auto next = *store->open_stream(kMap, keep_all(), at(1000));
  EXPECT_EQ(next.id, first.id);
  EXPECT_EQ(numbers(next.history), std::vector<std::uint32_t>{1});
}

// No file of this process may grow, as on a full disk.
TEST_F(DurableStoreTest, StoreWithoutRoom_ReportsItAndGoesOnWithNewRoom) {
  std::signal(SIGXFSZ, SIG_IGN);
  auto store = open();
  const auto stream = *store->open_stream(kMap, keep_all(), at(1000));
  std::uint32_t next = 0;
  for (; next < 100; ++next) store->append(stream.id, sample(next), at(0));
  ASSERT_TRUE(store->flush(10s));
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit tight{64 << 10, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &tight), 0);
  for (; next < 5000; ++next) store->append(stream.id, sample(next), at(0));
  const auto failed = store->flush(10s);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  ASSERT_EQ(code_of(failed), Code::rtps_store_failed);
  EXPECT_EQ(failed.error().details().document, path);
  EXPECT_NE(failed.error().details().found.find(std::strerror(EFBIG)), std::string::npos)
      << failed.error().details().found;
  {
    const std::lock_guard held(events.mutex);
    ASSERT_FALSE(events.all.empty());
    EXPECT_EQ(events.all[0].error.code(), Code::rtps_store_failed);
  }
  Status status;
  for (int i = 0; i < 100 && !(status = store->flush(100ms)); ++i) ::usleep(20'000);
  EXPECT_TRUE(status);
  store = nullptr;
  const auto history = open()->open_stream(kMap, keep_all(), at(1000))->history;
  ASSERT_EQ(history.size(), 5000u);
  for (std::uint32_t i = 0; i < 5000; ++i) ASSERT_EQ(number_of(history[i]), i);
}

// A topic that appears while the disk is full must not be refused.
TEST_F(DurableStoreTest, AStream_OpenedWithoutRoom_IsStoredWhenThereIsSome) {
  std::signal(SIGXFSZ, SIG_IGN);
  auto store = open();
  auto other = kMap;
  other.topic = "Other";
  const auto first = *store->open_stream(kMap, keep_all(), at(1000));
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit none{0, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &none), 0);
  store->append(first.id, sample(1), at(0));
  EXPECT_EQ(code_of(store->flush(10s)), Code::rtps_store_failed);
  const auto second = store->open_stream(other, keep_all(), at(1000));
  store->close_stream(first.id);
  const auto again = store->open_stream(kMap, keep_all(), at(1000));
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  ASSERT_TRUE(second) << second.error().to_sentence();
  EXPECT_EQ(code_of(again), Code::rtps_store_failed) << "its history is not complete yet";
  store->append(second->id, sample(2), at(0));
  for (int i = 0; i < 500 && !store->flush(10s); ++i) ::usleep(10'000);
  const auto complete = store->open_stream(kMap, keep_all(), at(1000));
  ASSERT_TRUE(complete);
  EXPECT_EQ(complete->id, first.id);
  EXPECT_EQ(numbers(complete->history), std::vector<std::uint32_t>{1});
  store.reset();
  EXPECT_EQ(numbers(open()->open_stream(other, keep_all(), at(1000))->history),
            std::vector<std::uint32_t>{2});
}

TEST_F(DurableStoreTest, FullQueue_IsBehind) {
  auto store = open();
  const auto stream = *store->open_stream(kMap, keep_last(1), at(1000));
  EXPECT_FALSE(store->is_behind());
  Change large = sample(0);
  large.payload = Payload::copy_of(Bytes(DurableStore::kMaxPendingOctets / 4));
  bool behind = false;
  for (int i = 0; i < 8; ++i) {
    store->append(stream.id, large, at(0));
    behind = behind || store->is_behind();
  }
  EXPECT_TRUE(behind);
  EXPECT_TRUE(store->wait_for_room(30s));
  EXPECT_FALSE(store->is_behind());
}

TEST_F(DurableStoreTest, LimitsThatAreReached_AreAnEvent) {
  auto service = keep_all();
  service.limits.max_samples = 1;
  auto store = open();
  const auto stream = *store->open_stream(kMap, service, at(1000));
  for (std::uint32_t i = 0; i < 3; ++i) store->append(stream.id, sample(i), at(0));
  ASSERT_TRUE(store->flush(10s));
  const std::lock_guard held(events.mutex);
  ASSERT_FALSE(events.all.empty());
  EXPECT_EQ(events.all[0].error.details().field, "DURABILITY_SERVICE");
}

// An exception of the application's sink must not end the process.
TEST_F(DurableStoreTest, ASinkThatThrows_DoesNotEndTheThread) {
  struct Throws final : EventSink {
    std::atomic<int> calls = 0;
    void raise(const Event&) override {
      ++calls;
      throw std::bad_alloc();
    }
  } throws;
  auto store = *DurableStore::open(path, throws);
  auto service = keep_all();
  service.limits.max_samples = 1;
  const auto stream = *store->open_stream(kMap, service, at(1000));
  for (std::uint32_t i = 0; i < 3; ++i) {
    store->append(stream.id, sample(i), at(0));
    ASSERT_TRUE(store->flush(10s));
  }
  EXPECT_EQ(throws.calls, 2);
  EXPECT_EQ(store->left_out(), 2u);
}

TEST_F(DurableStoreTest, StoreInMemory_LastsAsLongAsItself) {
  auto store = *DurableStore::open("", events);
  const auto stream = *store->open_stream(kMap, keep_all(), at(1000));
  store->append(stream.id, sample(1), at(0));
  store->close_stream(stream.id);
  EXPECT_EQ(store->open_stream(kMap, keep_all(), at(1000))->history.size(), 1u);
}

// An insider that writes as fast as the disk allows must not keep others from being stored. Without
// shares, this lasted for 8 s.
TEST_F(DurableStoreTest, ChangesOfOneIdentity_LeaveRoomInTheQueue) {
  auto store = open();
  const auto stream = *store->open_stream(kMap, keep_last(1), at(1000));
  const auto append = [&](std::uint8_t identity, std::size_t octets) {
    StoredChange change{stream.id, sample(identity, 200)};
    change.change.payload = Payload::copy_of(Bytes(octets));
    change.identity.emplace().octets[0] = identity;
    return store->append(std::move(change), at(0)).outcome.decision;
  };
  using enum SampleIndex::Decision;
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit none{0, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &none), 0);
  constexpr auto kMax = DurableStore::kMaxPendingOctetsOfOne;
  EXPECT_EQ(append(1, 2 * kMax), stored) << "one is always taken";
  EXPECT_EQ(append(1, 10), waits);
  for (std::uint8_t other = 2; other < 20; ++other) {
    EXPECT_EQ(append(other, kMax / 2), stored);
    EXPECT_EQ(append(other, kMax), waits);
  }
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  for (int i = 0; i < 500 && !store->flush(10s); ++i) ::usleep(10'000);
  EXPECT_EQ(append(1, 10), stored);
}

// A dispose or unregister without a payload costs memory and work of a commit, too.
TEST_F(DurableStoreTest, EndsWithoutPayload_LeaveRoomInTheQueue) {
  auto store = open();
  const auto stream = *store->open_stream(kMap, keep_last(1), at(1000));
  const auto append = [&](std::uint8_t identity, std::uint32_t instance, StatusInfo status) {
    StoredChange change{.stream = stream.id, .is_remembered = true};
    std::memcpy(change.change.key_hash.emplace().data(), &instance, sizeof instance);
    change.change.status = status;
    change.change.is_key_only = true;
    change.identity.emplace().octets[0] = identity;
    return store->append(std::move(change), at(0)).outcome.decision;
  };
  constexpr StatusInfo kDispose{true, false}, kUnregister{false, true};
  using enum SampleIndex::Decision;
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit none{0, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &none), 0);
  for (const std::uint8_t identity : {1, 2, 3}) {
    std::size_t accepted = 0;
    while (accepted < 100'000 && append(identity, static_cast<std::uint32_t>(accepted),
                                        identity == 1 ? kUnregister : kDispose) == ended)
      ++accepted;
    EXPECT_GT(accepted, 1000u);
    EXPECT_LE(accepted, DurableStore::kMaxPending / 4);
  }
  EXPECT_FALSE(store->is_behind());
  for (std::uint32_t instance = 0; instance < 10; ++instance)
    EXPECT_EQ(append(4, instance, kDispose), ended);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  for (int i = 0; i < 500 && !store->flush(10s); ++i) ::usleep(10'000);
  EXPECT_EQ(append(1, 0, kDispose), ended);
}

}  // namespace
}  // namespace ddssec::rtps
