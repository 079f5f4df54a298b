#include "rtps/participant/second_reading.hpp"

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

constexpr MonotonicTime kStart = std::chrono::hours(1);

TEST(SecondReadingTest, ManyChanges_LeadToOneReading) {
  SecondReading reading;
  EXPECT_EQ(reading.due(), kNever);
  EXPECT_FALSE(reading.take_due(kStart));
  for (int i = 0; i < 100; ++i) reading.note_change(kStart + std::chrono::milliseconds(i));
  EXPECT_EQ(reading.due(), kStart + SecondReading::kMinPause);
  EXPECT_FALSE(reading.take_due(reading.due() - MonotonicTime(1)));
  EXPECT_TRUE(reading.take_due(kStart + SecondReading::kMinPause));
  EXPECT_FALSE(reading.take_due(kStart + SecondReading::kMaxPause));
}

TEST(SecondReadingTest, ChangesThatGoOn_LeadToReadingsLessAndLessOften) {
  SecondReading reading;
  auto now = kStart;
  int readings = 0;
  for (; now < kStart + std::chrono::hours(1); now += std::chrono::seconds(1)) {
    reading.note_change(now);
    readings += reading.take_due(now) ? 1 : 0;
  }
  EXPECT_GE(readings, 15);
  EXPECT_LE(readings, 22);
}

TEST(SecondReadingTest, AfterALongRest_PauseIsShortAgain) {
  SecondReading reading;
  for (auto now = kStart; now < kStart + std::chrono::minutes(10); now += std::chrono::seconds(1)) {
    reading.note_change(now);
    reading.take_due(now);
  }
  ASSERT_NE(reading.due(), kNever);
  EXPECT_TRUE(reading.take_due(reading.due()));
  const auto later = kStart + std::chrono::hours(1);
  reading.note_change(later);
  EXPECT_EQ(reading.due(), later + SecondReading::kMinPause);
}

}  // namespace
}  // namespace ddssec::rtps
