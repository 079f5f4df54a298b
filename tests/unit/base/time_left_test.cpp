#include "base/time_left.hpp"

#include <gtest/gtest.h>

namespace ddssec {
namespace {

using namespace std::chrono_literals;

TEST(TimeLeft, End_IsWrittenWithItsDistance) {
  const WallTime end{std::chrono::sys_days(std::chrono::year(2027) / 1 / 1)};
  const auto text = [&](std::chrono::seconds left) {
    return in_time(end, end - left).substr(to_string(end).size());
  };
  EXPECT_EQ(in_time(end, end - 145h), "2027-01-01T00:00:00Z, in 6 days");
  EXPECT_EQ(text(24h), ", in 1 day");
  EXPECT_EQ(text(24h - 1s), ", in 23 hours");
  EXPECT_EQ(text(119s), ", in 1 minute");
  EXPECT_EQ(text(59s), ", in 59 seconds");
  EXPECT_EQ(text(0s), ", 0 seconds ago");
  EXPECT_EQ(text(-1s), ", 1 second ago");
  EXPECT_EQ(text(-23h), ", 23 hours ago");
  EXPECT_EQ(text(-72h), ", 3 days ago");
}

}  // namespace
}  // namespace ddssec
