#include "plugins/spi/end_warning.hpp"

#include <gtest/gtest.h>

#include "plugins/spi/property_names.hpp"

namespace ddssec::spi {
namespace {

using namespace std::chrono_literals;
using std::chrono::days;

constexpr WallTime kBegin{std::chrono::sys_days(std::chrono::year(2026) / 1 / 1)};
constexpr WallTime kEnd = kBegin + days(365);

Result<WarningDays> parse(std::string value) {
  return warning_days({{std::string(property::kWarnBeforeEnd), std::move(value)}});
}

TEST(WarningDays, Text_IsNumbersWithCommas_InAnyOrder) {
  EXPECT_EQ(warning_days({}), (WarningDays{days(30), days(7), days(1)}));
  EXPECT_EQ(parse("0"), WarningDays{});
  EXPECT_EQ(parse("3650"), WarningDays{days(3650)});
  EXPECT_EQ(parse("2,14,1"), (WarningDays{days(14), days(2), days(1)}));
  EXPECT_TRUE(parse("1,2,3,4,5,6,7,8"));
}

TEST(WarningDays, OtherText_IsRefused) {
  for (const auto* const bad :
       {"", "-1", "7d", " 7", "7, 1", "7,", ",7", "0,1", "3651", "1,2,3,4,5,6,7,8,9"}) {
    const auto refused = parse(bad);
    ASSERT_FALSE(refused) << bad;
    EXPECT_EQ(refused.error().code(), Code::invalid_property);
    EXPECT_EQ(refused.error().details().document, property::kWarnBeforeEnd);
  }
}

struct Asked {
  bool operator()(std::chrono::seconds before) {
    return warning.is_due(kBegin, kEnd, kEnd - before);
  }
  EndWarning warning{{days(30), days(7), days(1)}};
};

TEST(EndWarning, EachDay_IsDueOnce) {
  Asked due;
  EXPECT_FALSE(due(days(30) + 1s));
  EXPECT_TRUE(due(days(30)));
  EXPECT_FALSE(due(days(29)));
  EXPECT_TRUE(due(days(7)));
  EXPECT_FALSE(due(days(7)));
  EXPECT_TRUE(due(days(1)));
  EXPECT_FALSE(due(1s));
  EXPECT_FALSE(due(0s));
  EXPECT_FALSE(due(-days(1)));
}

TEST(EndWarning, DaysThatPassedTogether_AreOneWarning) {
  Asked due;
  EXPECT_TRUE(due(days(2)));
  EXPECT_FALSE(due(days(2) - 1s));
  EXPECT_TRUE(due(days(1)));
}

TEST(EndWarning, ClockSetBack_RepeatsNoWarning) {
  Asked due;
  EXPECT_TRUE(due(days(1)));
  EXPECT_FALSE(due(days(20)));
  EXPECT_FALSE(due(days(1)));
}

TEST(EndWarning, AnotherEnd_IsWarnedOfAnew) {
  Asked due;
  EXPECT_TRUE(due(days(1)));
  EXPECT_FALSE(due.warning.is_due(kBegin, kEnd + days(365), kEnd - days(1)));
  EXPECT_TRUE(due.warning.is_due(kBegin, kEnd + days(5), kEnd));
}

TEST(EndWarning, ShortLife_IsNotWarnedOfFromTheStart) {
  EndWarning warning({days(30), days(7), days(1)});
  const auto is_due = [&](auto left) {
    return warning.is_due(kBegin, kBegin + days(9), kBegin + days(9) - left);
  };
  EXPECT_FALSE(is_due(days(9)));
  EXPECT_FALSE(is_due(days(5)));
  EXPECT_TRUE(is_due(days(1)));
}

TEST(EndWarning, ValidityTooShortForAllDays_IsWarnedOfInItsLastSixth) {
  EndWarning warning({days(30), days(7), days(1)});
  const auto is_due = [&](auto left) {
    return warning.is_due(kBegin, kBegin + 48h, kBegin + 48h - left);
  };
  EXPECT_FALSE(is_due(24h));
  EXPECT_FALSE(is_due(9h));
  EXPECT_TRUE(is_due(8h));
  EXPECT_FALSE(is_due(1h));
  EXPECT_FALSE(is_due(0h));
}

TEST(EndWarning, WarningWithoutDays_IsNeverDue) {
  EXPECT_FALSE(EndWarning({}).is_due(kBegin, kEnd, kEnd - 1s));
}

}  // namespace
}  // namespace ddssec::spi
