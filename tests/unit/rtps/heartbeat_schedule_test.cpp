#include "rtps/reliability/heartbeat_schedule.hpp"

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

using std::chrono::milliseconds;

constexpr MonotonicTime kStart = milliseconds(5000);
constexpr auto kPeriod = HeartbeatSchedule::kFirstPeriod;

TEST(HeartbeatSchedule, NothingWritten_NoneIsDue) { EXPECT_EQ(HeartbeatSchedule().due(), kNever); }

TEST(HeartbeatSchedule, MoreSamples_DoNotPutItOff) {
  HeartbeatSchedule schedule;
  schedule.note_written(kStart);
  schedule.note_written(kStart + milliseconds(90));
  EXPECT_EQ(schedule.due(), kStart + kPeriod);
}

TEST(HeartbeatSchedule, NoAnswer_ThePeriodGrowsToItsLimit) {
  HeartbeatSchedule schedule;
  schedule.restart(kStart);
  for (int i = 0; i < HeartbeatSchedule::kMaxUnanswered; ++i) schedule.note_sent(kStart, false);
  EXPECT_EQ(schedule.due(), kStart + kPeriod);
  schedule.note_sent(kStart, false);
  EXPECT_EQ(schedule.due(), kStart + 2 * kPeriod);
  for (int i = 0; i < 10; ++i) schedule.note_sent(kStart, false);
  EXPECT_EQ(schedule.due(), kStart + HeartbeatSchedule::kMaxPeriod);
}

TEST(HeartbeatSchedule, ARequest_BringsTheNextSoon) {
  HeartbeatSchedule schedule;
  schedule.restart(kStart);
  for (int i = 0; i < 20; ++i) schedule.note_sent(kStart, false);
  schedule.note_request(kStart);
  EXPECT_EQ(schedule.due(), kStart + kPeriod);
  schedule.note_request(kStart + milliseconds(50));
  EXPECT_EQ(schedule.due(), kStart + kPeriod) << "it does not put it off";
  schedule.note_sent(kStart, false);
  EXPECT_EQ(schedule.due(), kStart + kPeriod) << "a reader was heard";
}

TEST(HeartbeatSchedule, AllAcknowledged_NoneIsDue) {
  HeartbeatSchedule schedule;
  schedule.restart(kStart);
  schedule.note_answer(kStart, true);
  EXPECT_EQ(schedule.due(), kNever);
  schedule.note_answer(kStart, false);
  EXPECT_EQ(schedule.due(), kStart + kPeriod);
  schedule.note_sent(kStart, true);
  EXPECT_EQ(schedule.due(), kNever);
}

}  // namespace
}  // namespace ddssec::rtps
