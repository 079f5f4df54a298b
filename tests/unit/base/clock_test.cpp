// Clocks, the written form of a time, and the reproducible random source of the tests.
#include "base/clock.hpp"

#include <gtest/gtest.h>

#include "tests/support/seeded_random.hpp"

namespace ddssec {
namespace {

using namespace std::chrono_literals;

TEST(WallTime, EveryYear_IsWrittenInUtc) {
  EXPECT_EQ(to_string(WallTime(0s)), "1970-01-01T00:00:00Z");
  EXPECT_EQ(to_string(WallTime(-1s)), "1969-12-31T23:59:59Z");
  EXPECT_EQ(to_string(WallTime(1'795'230'823s)), "2026-11-21T03:13:43Z");
  // This time is later than a count of nanoseconds since 1970 can express.
  EXPECT_EQ(to_string(WallTime(253'402'300'799s)), "9999-12-31T23:59:59Z");
}

TEST(ManualClock, Advance_MovesBothClocksAndKeepsFractions) {
  ManualClock clock{WallTime(100s)};
  clock.advance(1'400ms);
  EXPECT_EQ(clock.calendar_seconds(), WallTime(101s));
  EXPECT_EQ(clock.calendar_nanoseconds(), 101'400ms);
  EXPECT_EQ(clock.monotonic(), 1'400ms);
  clock.advance(600ms);
  EXPECT_EQ(clock.calendar_seconds(), WallTime(102s));
  EXPECT_EQ(clock.since_boot(), 2s);
}

TEST(ManualClock, SettingTheCalendar_LeavesTheMonotonicClock) {
  ManualClock clock{WallTime(100s)};
  clock.advance(3s);
  clock.set(WallTime(50s));
  EXPECT_EQ(clock.calendar_seconds(), WallTime(50s));
  EXPECT_EQ(clock.monotonic(), 3s);
}

TEST(SystemClock, Time_NeverGoesBackAndCountsSleep) {
  const SystemClock clock;
  const auto first = clock.monotonic();
  EXPECT_GE(clock.monotonic(), first);
  EXPECT_GE(clock.since_boot(), first) << "it leaves out time that monotonic() counts";
  EXPECT_LE(clock.calendar_seconds().time_since_epoch(), clock.calendar_nanoseconds());
  EXPECT_LT(clock.calendar_nanoseconds() - clock.calendar_seconds().time_since_epoch(), 2s);
}

TEST(SeededRandom, SameSeed_GivesTheSameStreamAndNoRepetition) {
  SeededRandom one(7), same(7), other(8);
  Bytes a(40), b(40), c(40), next(40);
  ASSERT_TRUE(one.fill(a) && same.fill(b) && other.fill(c) && one.fill(next));
  EXPECT_EQ(a, b);
  EXPECT_NE(a, c);
  EXPECT_NE(a, next);
}

TEST(SystemRandomOctets, TwoCalls_GiveDifferentOctets) {
  Bytes a(32), b(32);
  SystemRandom system;
  ASSERT_TRUE(system.fill(a));
  ASSERT_TRUE(system.fill(b));
  EXPECT_NE(a, b);
}

}  // namespace
}  // namespace ddssec
