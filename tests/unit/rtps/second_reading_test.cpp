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

TEST(SecondReadingTest, EndpointsThatEnded_AreReturnedWhenTheReadingIsOver) {
  const auto endpoint = [](int number) {
    return EntityId{{0, 0, static_cast<std::uint8_t>(number), 7}};
  };
  SecondReading reading;
  EXPECT_TRUE(reading.note_end(endpoint(1), kStart));
  EXPECT_TRUE(reading.take_read(kStart + SecondReading::kMinPause).empty());
  ASSERT_TRUE(reading.take_due(kStart + SecondReading::kMinPause));
  const auto over = kStart + SecondReading::kMinPause + SecondReading::kPatience;
  EXPECT_EQ(reading.next(), over);
  EXPECT_TRUE(reading.note_end(endpoint(2), over));
  EXPECT_EQ(reading.take_read(over), std::vector{endpoint(1)});
  EXPECT_EQ(reading.next(), reading.due()) << "the second one is not read yet";
  std::size_t more = 0;
  while (reading.note_end(endpoint(3), over)) ++more;
  EXPECT_EQ(more + 1, SecondReading::kMaxEnded);
}

}  // namespace
}  // namespace ddssec::rtps
