// A process that stores is killed at random moments. What was reported as stored is there, and the
// file has only whole samples in their order.
#include <csignal>
#include <random>
#include <sys/wait.h>

#include "tests/unit/rtps_durability/store_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;
using namespace std::chrono_literals;

constexpr std::uint32_t kInstances = 3;

// Stores until it is killed. Reports through `out` which samples are safe.
[[noreturn]] void child(const std::string& path, std::uint32_t next,
                        const DurabilityService& service, int out) {
  test::RecordedEvents events;
  auto store = DurableStore::open(path, events);
  if (!store) ::_exit(2);
  const auto stream = (*store)->open_stream(kMap, service, at(1000));
  if (!stream) ::_exit(3);
  std::mt19937 random(next);
  for (;;) {
    for (auto count = 1 + random() % 50; count > 0; --count)
      (*store)->append(stream->id, sample(next++, kInstances), at(0));
    if (!(*store)->flush(10s)) ::_exit(4);
    if (::write(out, &next, sizeof next) != sizeof next) ::_exit(5);
  }
}

struct KillTest : StoreTest, ::testing::WithParamInterface<DurabilityService> {
  // Runs a child and kills it after that time. Returns the number after the last sample that is
  // safe.
  std::uint32_t run_and_kill(std::uint32_t next, std::chrono::microseconds after) {
    int ends[2];
    EXPECT_EQ(::pipe(ends), 0);
    const auto pid = ::fork();
    if (pid == 0) {
      ::close(ends[0]);
      child(path, next, GetParam(), ends[1]);
    }
    ::close(ends[1]);
    std::uint32_t safe = next;
    EXPECT_EQ(::read(ends[0], &safe, sizeof safe), static_cast<ssize_t>(sizeof safe));
    ::usleep(static_cast<useconds_t>(after.count()));
    ::kill(pid, SIGKILL);
    while (::read(ends[0], &safe, sizeof safe) == static_cast<ssize_t>(sizeof safe)) {
    }
    ::close(ends[0]);
    int status = 0;
    ::waitpid(pid, &status, 0);
    EXPECT_TRUE(WIFSIGNALED(status));
    return safe;
  }
};

TEST_P(KillTest, KilledAtAnyTime_LosesNothingStoredAndLeavesNothingHalf) {
  std::mt19937 random(7);
  std::uint32_t next = 0;
  const bool all = GetParam().history.kind == HistoryKind::keep_all;
  for (int round = 0; round < 12; ++round) {
    const auto safe = run_and_kill(next, std::chrono::microseconds(random() % 20'000));
    test::RecordedEvents events;
    auto store = DurableStore::open(path, events);
    ASSERT_TRUE(store) << store.error().to_sentence();
    const auto stream = (*store)->open_stream(kMap, GetParam(), at(1000));
    ASSERT_TRUE(stream) << stream.error().to_sentence();
    const auto held = numbers(stream->history, kInstances);
    ASSERT_FALSE(held.empty());
    next = held.back() + 1;
    EXPECT_GE(next, safe);
    // The last samples are there, and all before them that had to be kept.
    const auto count = all ? next : 2 * kInstances;
    ASSERT_EQ(held.size(), count);
    for (std::uint32_t i = 0; i < count; ++i) ASSERT_EQ(held[i], next - count + i);
  }
}

INSTANTIATE_TEST_SUITE_P(Both, KillTest, ::testing::Values(keep_all(), keep_last(2)),
                         [](const auto& info) { return info.index == 0 ? "KeepAll" : "KeepLast"; });

}  // namespace
}  // namespace ddssec::rtps
