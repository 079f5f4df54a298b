// An allocation that fails, or a thread that cannot be started, ends neither the process nor the
// participant.
#include <dlfcn.h>
#include <pthread.h>

#include "tests/support/counted_memory.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"
#include "tests/unit/rtps_durability/store_fixture.hpp"

// If a test says so, no further thread can be started.
static std::atomic<bool> no_threads = false;

extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes,
                              void* (*start)(void*), void* argument) {
  if (no_threads) return EAGAIN;
  static const auto real =
      reinterpret_cast<decltype(&pthread_create)>(dlsym(RTLD_NEXT, "pthread_create"));
  return real(thread, attributes, start, argument);
}

namespace ddssec::rtps {
namespace {

using namespace testing;
namespace memory = counted_memory;

constexpr int kMaxAllocations = 3000;

struct OutOfMemory : Polled {
  // Lets an allocation fail while messages from `other` are served.
  void serve_with_failure(End& other, std::int64_t after) {
    for (int i = 0; i < 4; ++i) {
      other.participant->poll(0ms);
      memory::fail_after(after);
      a.participant->poll(0ms);
      memory::fail_after(-1);
    }
  }
  // Expects that a further participant is discovered, and that its samples arrive.
  void expect_to_go_on() {
    End other(services, options());
    auto& reader = a.reader(reliable());
    auto& writer = other.writer(reliable());
    ASSERT_TRUE(writer.write({"north", 7}));
    std::vector<std::int64_t> values;
    for (int i = 0; i < 3000 && values.empty(); ++i) {
      run(10ms);
      other.participant->poll(0ms);
      ASSERT_TRUE(writer.write({"north", 7}));
      values = taken(reader);
    }
    EXPECT_FALSE(values.empty());
    const auto count = a.participant->counters().exceptions;
    EXPECT_GT(count, 5u);
    const std::lock_guard held(events.mutex);
    const auto reported = std::ranges::count(events.all, Code::rtps_exception,
                                             [](const Event& event) { return event.error.code(); });
    EXPECT_EQ(reported, std::bit_width(count)) << "on the 1st, 2nd, 4th, 8th ... time";
  }
};

// std::bad_alloc must not leave poll(), and must not end the process of a participant with its own
// thread.
TEST_P(OutOfMemory, AnyAllocation_WhileEndpointsAppear_EndsNothingElse) {
  for (std::int64_t after = 0; after < kMaxAllocations; after += 1 + after / 16) {
    auto& reader = a.reader(reliable());
    auto& writer = b.writer(reliable());
    ASSERT_TRUE(writer.write({"north", after}));
    serve_with_failure(b, after);
    run(50ms);
    ASSERT_TRUE(a.subscriber->delete_datareader(reader));
    ASSERT_TRUE(b.publisher->delete_datawriter(writer));
    serve_with_failure(b, after);
  }
  expect_to_go_on();
}

TEST_P(OutOfMemory, AnyAllocation_WhileParticipantsAppear_EndsNothingElse) {
  a.reader(reliable());
  for (std::int64_t after = 0; after < kMaxAllocations; after += 1 + after / 8) {
    End other(services, options());
    ASSERT_TRUE(other.writer(reliable()).write({"north", after}));
    serve_with_failure(other, after);
    run(50ms);
  }
  expect_to_go_on();
}

INSTANTIATE_TEST_SUITE_P(Over, OutOfMemory, ::testing::Values(Way::network, Way::in_process),
                         testing::name_of);

TEST_F(StoreTest, AnyAllocationThatFailsWhileStoring_LeavesAStoreThatGoesOn) {
  auto store = IndexedStore::open(path);
  ASSERT_TRUE(store) << store.error().to_sentence();
  auto service = keep_last(2);
  service.cleanup_delay = Duration{{10, 0}};
  const auto stream = store->stream(kMap, service);
  ASSERT_TRUE(stream);
  std::uint32_t number = 0;
  bool all = false;
  for (std::int64_t after = 0; !all; ++after) {
    std::vector<StoredChange> group;
    for (int i = 0; i < 3; ++i) group.push_back({*stream, sample(number++, 5)});
    group.push_back({*stream, dispose(number % 5)});
    memory::fail_after(after);
    try {
      static_cast<void>(store->commit(group, seconds(1)));
    } catch (const std::bad_alloc&) {
    }
    all = !memory::has_failed();
    memory::fail_after(-1);
    ASSERT_TRUE(store->commit(group, seconds(1))) << "after " << after;
    const auto held = store->store.load(*stream);
    ASSERT_TRUE(held);
    EXPECT_EQ(held->changes.size(), store->size(*stream));
    EXPECT_TRUE(held->changes.back().status.disposed);
    EXPECT_EQ(number_of(held->changes[held->changes.size() - 2], 5), number - 1);
  }
}

TEST(NoThreads, ParticipantOrStore_IsAnError) {
  const SystemClock clock;
  SystemRandom random;
  test::RecordedEvents events;
  no_threads = true;
  const auto participant = DomainParticipant::create(
      {.domain_id = 73, .interfaces = {"127.0.0.1"}, .multicast = false}, {clock, random, events});
  const auto store = DurableStore::open("", events);
  no_threads = false;
  EXPECT_EQ(code_of(participant), Code::rtps_thread_failed);
  EXPECT_EQ(code_of(store), Code::rtps_thread_failed);
}

}  // namespace
}  // namespace ddssec::rtps
