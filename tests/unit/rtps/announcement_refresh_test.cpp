#include "rtps/participant/announcement_refresh.hpp"

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

constexpr MonotonicTime kStart = std::chrono::hours(1);

TEST(AnnouncementRefreshTest, ManyChanges_LeadToOneReading) {
  AnnouncementRefresh reading;
  EXPECT_EQ(reading.due(), kNever);
  EXPECT_FALSE(reading.begin_refresh_if_due(kStart));
  for (int i = 0; i < 100; ++i) reading.note_change(kStart + std::chrono::milliseconds(i));
  EXPECT_EQ(reading.due(), kStart + AnnouncementRefresh::kMinPause);
  EXPECT_FALSE(reading.begin_refresh_if_due(reading.due() - MonotonicTime(1)));
  EXPECT_TRUE(reading.begin_refresh_if_due(kStart + AnnouncementRefresh::kMinPause));
  EXPECT_FALSE(reading.begin_refresh_if_due(kStart + AnnouncementRefresh::kMaxPause));
}

TEST(AnnouncementRefreshTest, ChangesThatGoOn_LeadToReadingsLessAndLessOften) {
  AnnouncementRefresh reading;
  auto now = kStart;
  int readings = 0;
  for (; now < kStart + std::chrono::hours(1); now += std::chrono::seconds(1)) {
    reading.note_change(now);
    readings += reading.begin_refresh_if_due(now) ? 1 : 0;
  }
  EXPECT_GE(readings, 15);
  EXPECT_LE(readings, 22);
}

TEST(AnnouncementRefreshTest, RoutineRefresh_DoesNotEndThePauseOfChangesThatGoOn) {
  AnnouncementRefresh reading;
  reading.begin(kStart, std::chrono::seconds(100));
  auto now = kStart;
  int readings = 0;
  for (; now < kStart + std::chrono::hours(1); now += std::chrono::milliseconds(700)) {
    reading.note_change(now);
    readings += reading.begin_refresh_if_due(now) ? 1 : 0;
  }
  EXPECT_GE(readings, 15);
  EXPECT_LE(readings, 24);
}

TEST(AnnouncementRefreshTest, PauseAfterALongRest_IsShortAgain) {
  AnnouncementRefresh reading;
  for (auto now = kStart; now < kStart + std::chrono::minutes(10); now += std::chrono::seconds(1)) {
    reading.note_change(now);
    reading.begin_refresh_if_due(now);
  }
  ASSERT_NE(reading.due(), kNever);
  EXPECT_TRUE(reading.begin_refresh_if_due(reading.due()));
  const auto later = kStart + std::chrono::hours(1);
  reading.note_change(later);
  EXPECT_EQ(reading.due(), later + AnnouncementRefresh::kMinPause);
}

EntityId endpoint(std::size_t number) {
  return EntityId{
      {0, static_cast<std::uint8_t>(number >> 8), static_cast<std::uint8_t>(number), 7}};
}

TEST(AnnouncementRefreshTest, EndpointsThatEnded_AreReturnedWhenTheReadingIsOver) {
  AnnouncementRefresh reading;
  EXPECT_TRUE(reading.note_end(endpoint(1), kStart));
  EXPECT_FALSE(reading.end_refresh_if_over(kStart + AnnouncementRefresh::kMinPause));
  ASSERT_TRUE(reading.begin_refresh_if_due(kStart + AnnouncementRefresh::kMinPause));
  const auto over = kStart + AnnouncementRefresh::kMinPause + AnnouncementRefresh::kAnswerTimeout;
  EXPECT_EQ(reading.next(), over);
  EXPECT_TRUE(reading.note_end(endpoint(2), over));
  ASSERT_TRUE(reading.end_refresh_if_over(over));
  EXPECT_FALSE(reading.end_refresh_if_over(over)) << "once";
  const auto read = reading.take_confirmed_ends();
  ASSERT_EQ(read.size(), 1u) << "the second one is not read yet";
  EXPECT_EQ(read[0].endpoint, endpoint(1));
  EXPECT_EQ(reading.next(), reading.due());
}

TEST(AnnouncementRefreshTest, AboveTheLimit_AnEndCountsOnlyWhenItIsRead) {
  AnnouncementRefresh reading;
  for (std::size_t i = 0; i < AnnouncementRefresh::kMaxEnded; ++i)
    EXPECT_TRUE(reading.note_end(endpoint(i), kStart));
  EXPECT_TRUE(reading.note_end(endpoint(0), kStart)) << "each takes room once";
  for (const auto more : {1000u, 1001u}) EXPECT_FALSE(reading.note_end(endpoint(more), kStart));
  reading.note_alive(endpoint(1001));
  ASSERT_TRUE(reading.begin_refresh_if_due(reading.due()));
  std::size_t uncounted = 0;
  for (const auto& ended : reading.take_confirmed_ends())
    if (!ended.counts) {
      ++uncounted;
      EXPECT_EQ(ended.endpoint, endpoint(1000));
    }
  EXPECT_EQ(uncounted, 1u);
  EXPECT_TRUE(reading.note_end(endpoint(1001), kStart)) << "there is room again";
}

TEST(AnnouncementRefreshTest, SeveralGoneWriters_TheFirstLosesItsKeys) {
  AnnouncementRefresh reading;
  for (std::size_t i = 0; i < AnnouncementRefresh::kMaxGone; ++i)
    EXPECT_FALSE(reading.note_gone(endpoint(i)));
  EXPECT_TRUE(reading.note_end(endpoint(0), kStart)) << "it had come back";
  EXPECT_FALSE(reading.note_gone(endpoint(1000)));
  EXPECT_EQ(reading.note_gone(endpoint(1001)), endpoint(1));
  EXPECT_TRUE(reading.without_keys().contains(endpoint(1)));
  for (std::size_t i = 0; i < 2 * AnnouncementRefresh::kMaxWithoutKeys; ++i)
    reading.note_gone(endpoint(2000 + i));
  EXPECT_EQ(reading.without_keys().size(), AnnouncementRefresh::kMaxWithoutKeys);
}

}  // namespace
}  // namespace ddssec::rtps
