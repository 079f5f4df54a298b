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

  ExpiryTimer::Tasks tasks() {
    return {.expire =
                [this] {
                  return ++rounds == 3 ? std::vector<std::int64_t>{77}
                                       : std::vector<std::int64_t>{};
                },
            .next_expiry = [] { return std::optional<WallTime>{}; },
            .revoke = [this](std::int64_t handle) { revoked.set_value(handle); }};
  }
};

TEST_F(Timer, RevokesWhatEndsOnce) {
  timer.start(tasks());
  auto future = revoked.get_future();
  ASSERT_EQ(future.wait_for(5s), std::future_status::ready);
  EXPECT_EQ(future.get(), 77);
  timer.stop();
}

TEST_F(Timer, NothingIsCalledAfterStop) {
  timer.start({.expire =
                   [this] {
                     ++rounds;
                     return std::vector<std::int64_t>{};
                   },
               .next_expiry = [] { return std::optional<WallTime>{}; },
               .revoke = [](std::int64_t) {}});
  while (rounds == 0) std::this_thread::sleep_for(1ms);
  timer.stop();
  const int at_stop = rounds;
  std::this_thread::sleep_for(30ms);
  EXPECT_EQ(rounds, at_stop);
  timer.stop();  // again
}

TEST_F(Timer, ARevocationMayStopTheTimer) {
  auto with_stop = tasks();
  with_stop.revoke = [this](std::int64_t handle) {
    timer.stop();
    revoked.set_value(handle);
  };
  timer.start(with_stop);
  EXPECT_EQ(revoked.get_future().wait_for(5s), std::future_status::ready);
}

TEST_F(Timer, AThrowingEngineIsAskedAgain) {
  auto throwing = tasks();
  throwing.expire = [this]() -> std::vector<std::int64_t> {
    if (++rounds < 3) throw std::bad_alloc();
    return {5};
  };
  throwing.revoke = [this](std::int64_t handle) {
    if (rounds == 3) revoked.set_value(handle);
  };
  timer.start(throwing);
  EXPECT_EQ(revoked.get_future().wait_for(5s), std::future_status::ready);
  timer.stop();
}

TEST_F(Timer, WakesForTheNextEndAndNotLater) {
  ExpiryTimer slow(clock, 10s);
  std::atomic<int> asked = 0;
  slow.start({.expire =
                  [&] {
                    ++asked;
                    return std::vector<std::int64_t>{};
                  },
              .next_expiry = [this] { return std::optional(clock.now() + 0s); },
              .revoke = [](std::int64_t) {}});
  const auto start = std::chrono::steady_clock::now();
  while (asked < 3 && std::chrono::steady_clock::now() - start < 5s)
    std::this_thread::sleep_for(5ms);
  EXPECT_GE(asked, 3);
  slow.stop();
}

}  // namespace
}  // namespace ddssec::cyclonedds
