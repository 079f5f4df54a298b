#include "plugins/cyclonedds/expiry_timer.hpp"

#include <atomic>
#include <future>

#include <gtest/gtest.h>

namespace ddssec::cyclonedds {
namespace {

using namespace std::chrono_literals;

struct Timer : testing::Test {
  SystemClock clock;
  ExpiryTimer timer{clock, 5ms};
  std::atomic<int> rounds = 0;
  std::promise<std::int64_t> revoked;

  // Returns tasks of which something ends in the third round.
  ExpiryTimer::Tasks tasks() {
    return {.revoke_ended =
                [this](const std::stop_token&) {
                  if (++rounds == 3) revoked.set_value(77);
                },
            .next_expiry = [] { return std::optional<WallTime>{}; }};
  }
};

TEST_F(Timer, EndedIdentity_IsRevokedOnce) {
  timer.start(tasks());
  auto future = revoked.get_future();
  ASSERT_EQ(future.wait_for(5s), std::future_status::ready);
  EXPECT_EQ(future.get(), 77);
  timer.stop();
}

TEST_F(Timer, StoppedTimer_CallsNothing) {
  timer.start({.revoke_ended = [this](const std::stop_token&) { ++rounds; },
               .next_expiry = [] { return std::optional<WallTime>{}; }});
  while (rounds == 0) std::this_thread::sleep_for(1ms);
  timer.stop();
  const int at_stop = rounds;
  std::this_thread::sleep_for(30ms);
  EXPECT_EQ(rounds, at_stop);
  timer.stop();  // a second time
}

TEST_F(Timer, WakeAll_EndsTheWait) {
  ExpiryTimer slow{clock, 60s};
  slow.start(tasks());
  for (int round = 1; round <= 3; ++round) {
    for (int i = 0; i < 500 && rounds < round; ++i) std::this_thread::sleep_for(10ms);
    ASSERT_EQ(rounds, round);
    ExpiryTimer::wake_all();
  }
  slow.stop();
  ExpiryTimer::wake_all();  // a timer that does not run
}

// A peer can repeat the message that wakes it.
TEST_F(Timer, WokenAllTheTime_RestsBetweenItsRounds) {
  ExpiryTimer slow(clock, 10s);
  std::atomic<int> asked = 0;
  slow.start({.revoke_ended = [&](const std::stop_token&) { ++asked; },
              .next_expiry = [] { return std::optional<WallTime>(); }});
  const auto start = std::chrono::steady_clock::now();
  while (std::chrono::steady_clock::now() - start < 5 * ExpiryTimer::kMinPause) {
    ExpiryTimer::wake_all();
    std::this_thread::sleep_for(100us);
  }
  const auto passed = std::chrono::steady_clock::now() - start;
  EXPECT_GE(asked, 2);
  EXPECT_LE(asked, 2 + passed / ExpiryTimer::kMinPause);
  slow.stop();
}

// Three identities end in one round.
TEST_F(Timer, ARevocation_MayStopTheTimer) {
  std::atomic<int> revocations = 0;
  const auto revoke_ended = [&](const std::stop_token& stop) {
    for (const int handle : {1, 2, 3}) {
      if (stop.stop_requested()) return;
      ++revocations;
      timer.stop();
      revoked.set_value(handle);
    }
  };
  timer.start({.revoke_ended = revoke_ended, .next_expiry = tasks().next_expiry});
  auto future = revoked.get_future();
  ASSERT_EQ(future.wait_for(5s), std::future_status::ready);
  EXPECT_EQ(future.get(), 1);
  timer.stop();
  EXPECT_EQ(revocations, 1);
}

TEST_F(Timer, ThrowingPlugin_IsAskedAgain) {
  auto throwing = tasks();
  throwing.revoke_ended = [this](const std::stop_token&) {
    if (++rounds < 3) throw std::bad_alloc();
    if (rounds == 3) revoked.set_value(5);
  };
  timer.start(throwing);
  EXPECT_EQ(revoked.get_future().wait_for(5s), std::future_status::ready);
  timer.stop();
}

TEST_F(Timer, NextEnd_WakesItAndNotLater) {
  ExpiryTimer slow(clock, 10s);
  std::atomic<int> asked = 0;
  slow.start({.revoke_ended = [&](const std::stop_token&) { ++asked; },
              .next_expiry = [this] { return std::optional(clock.calendar_seconds() + 0s); }});
  const auto start = std::chrono::steady_clock::now();
  while (asked < 3 && std::chrono::steady_clock::now() - start < 5s)
    std::this_thread::sleep_for(5ms);
  EXPECT_GE(asked, 3);
  slow.stop();
}

}  // namespace
}  // namespace ddssec::cyclonedds
