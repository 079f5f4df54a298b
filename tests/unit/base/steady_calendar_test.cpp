#include "base/steady_calendar.hpp"

#include <gtest/gtest.h>

namespace ddssec {
namespace {

using namespace std::chrono_literals;

constexpr WallTime kStart{std::chrono::sys_days{std::chrono::January / 1 / 2026}};

struct SteadyCalendarTest : testing::Test {
  ManualClock clock{kStart};
  SteadyCalendar calendar{clock};

  std::optional<Code> news() {
    const auto error = calendar.take_report();
    return error ? std::optional(error->code()) : std::nullopt;
  }
  // Looks once a second, as a host does.
  void pass(std::chrono::seconds time) {
    for (auto i = 0s; i < time; ++i) {
      clock.advance(1s);
      calendar.calendar_seconds();
    }
  }
};

TEST_F(SteadyCalendarTest, ClockThatIsNotStepped_IsFollowed) {
  clock.advance(400 * 24h + 3ns);
  EXPECT_EQ(calendar.calendar_seconds(), kStart + 400 * 24h);
  EXPECT_EQ(calendar.calendar_nanoseconds(), clock.calendar_nanoseconds());
  EXPECT_EQ(calendar.monotonic(), clock.monotonic());
  EXPECT_FALSE(news());
}

TEST_F(SteadyCalendarTest, SmallAdjustments_AreFollowedAtOnce) {
  for (int i = 1; i <= 20; ++i) {
    clock.set(clock.calendar_seconds() + 10s);
    EXPECT_EQ(calendar.calendar_seconds(), kStart + i * 10s);
  }
  EXPECT_FALSE(news());
}

TEST_F(SteadyCalendarTest, SetForSomeSeconds_NothingIsJudgedByIt) {
  for (const auto by : {365 * 24h, -72h}) {
    const auto before = clock.calendar_seconds();
    clock.set(before + by);
    EXPECT_EQ(calendar.calendar_seconds(), before);
    EXPECT_EQ(news(), Code::clock_stepped);
    pass(6s);
    EXPECT_EQ(calendar.calendar_seconds(), before + 6s);
    EXPECT_FALSE(news()) << "said once";
    clock.set(clock.calendar_seconds() - by);
    EXPECT_EQ(calendar.calendar_seconds(), before + 6s);
    EXPECT_EQ(news(), Code::clock_step_undone);
    EXPECT_FALSE(news());
  }
}

TEST_F(SteadyCalendarTest, SetToStay_CountsAfterTheGrace) {
  clock.set(kStart + 1000h);
  EXPECT_EQ(news(), Code::clock_stepped);
  pass(59s);
  EXPECT_EQ(calendar.calendar_seconds(), kStart + 59s);
  EXPECT_FALSE(news());
  pass(1s);
  EXPECT_EQ(calendar.calendar_seconds(), kStart + 1000h + 60s);
  EXPECT_EQ(news(), Code::clock_step_followed);
  pass(10s);
  EXPECT_EQ(calendar.calendar_seconds(), kStart + 1000h + 70s);
  EXPECT_FALSE(news());
}

// Otherwise the grace would never end.
TEST_F(SteadyCalendarTest, SetAgainAndAgain_TheGraceIsOne) {
  for (int i = 1; i <= 60; ++i) {
    clock.set(kStart + i * 1000h);
    EXPECT_LT(calendar.calendar_seconds(), kStart + 1h);
    clock.advance(1s);
  }
  EXPECT_GT(calendar.calendar_seconds(), kStart + 59000h);
}

TEST_F(SteadyCalendarTest, ZeroGrace_FollowsAtOnceWithoutReport) {
  calendar.set_grace(0s);
  clock.set(kStart + 1000h);
  EXPECT_EQ(calendar.calendar_seconds(), kStart + 1000h);
  EXPECT_FALSE(news());
}

TEST_F(SteadyCalendarTest, Step_SaysBothTimes) {
  clock.set(kStart + 24h);
  const auto error = calendar.take_report();
  ASSERT_TRUE(error);
  EXPECT_EQ(error->details().expected, "2026-01-01T00:00:00Z");
  EXPECT_EQ(error->details().found, "2026-01-02T00:00:00Z");
}

// The clock of a machine that slept: more time has passed than a monotonic clock counts.
struct Asleep final : Clock {
  std::chrono::nanoseconds slept{0};
  WallTime calendar_seconds() const override {
    return std::chrono::floor<std::chrono::seconds>(kStart + slept);
  }
  std::chrono::nanoseconds monotonic() const override { return 0ns; }
  std::chrono::nanoseconds since_boot() const override { return slept; }
};

TEST(SleepingMachine, Wakes_TheTimeOfItsSleepHasPassed) {
  Asleep clock;
  SteadyCalendar calendar(clock);
  clock.slept = 100h;
  EXPECT_EQ(calendar.calendar_seconds(), kStart + 100h);
  EXPECT_FALSE(calendar.take_report());
}

TEST(SystemClock, SinceBoot_NeverGoesBack) {
  const SystemClock clock;
  const auto before = clock.since_boot();
  EXPECT_GT(before, 0ns);
  EXPECT_GE(clock.since_boot(), before);
}

}  // namespace
}  // namespace ddssec
