#include "governance/date_time.hpp"

#include <gtest/gtest.h>

namespace ddssec::governance {
namespace {

std::string read(std::string_view text, Round round = Round::down) {
  const auto moment = parse_date_time(text, round);
  return moment ? to_string(moment->time) : "refused";
}

TEST(DateTime, EachZone_IsRead) {
  EXPECT_EQ(read("2026-11-21T03:13:43Z"), "2026-11-21T03:13:43Z");
  EXPECT_EQ(read("2026-11-21T03:13:43"), "2026-11-21T03:13:43Z");
  EXPECT_EQ(read("2026-11-21T03:13:43+05:30"), "2026-11-20T21:43:43Z");
  EXPECT_EQ(read("2026-11-21T03:13:43-14:00"), "2026-11-21T17:13:43Z");
  EXPECT_FALSE(parse_date_time("2026-11-21T03:13:43", Round::down)->has_zone);
  EXPECT_TRUE(parse_date_time("2026-11-21T03:13:43Z", Round::down)->has_zone);
}

TEST(DateTime, Fractions_AreRoundedAsAsked) {
  EXPECT_EQ(read("2026-11-21T03:13:43.999Z", Round::down), "2026-11-21T03:13:43Z");
  EXPECT_EQ(read("2026-11-21T03:13:43.001Z", Round::up), "2026-11-21T03:13:44Z");
  EXPECT_EQ(read("2026-11-21T03:13:43.000", Round::up), "2026-11-21T03:13:43Z");
}

TEST(DateTime, LeapDaysAndFarYears_AreRead) {
  EXPECT_EQ(read("2028-02-29T00:00:00Z"), "2028-02-29T00:00:00Z");
  EXPECT_EQ(read("2026-12-31T24:00:00Z"), "2027-01-01T00:00:00Z");
  EXPECT_EQ(read("2115-09-15T01:00:00"), "2115-09-15T01:00:00Z");
  EXPECT_EQ(read("9999-12-31T23:59:59Z"), "9999-12-31T23:59:59Z");
  EXPECT_EQ(read("1970-01-01T00:00:00Z"), "1970-01-01T00:00:00Z");
}

class NotADateTime : public testing::TestWithParam<const char*> {};
TEST_P(NotADateTime, OtherText_IsRefused) { EXPECT_EQ(read(GetParam()), "refused"); }
INSTANTIATE_TEST_SUITE_P(
    Table, NotADateTime,
    testing::Values("", "2026", "2026-11-21", "2026-11-21 03:13:43", "2026-11-21T03:13",
                    "2026-11-21T03:13:43z", "2026-11-21T3:13:43", "2026-13-21T03:13:43",
                    "2026-02-29T03:13:43", "2026-11-00T03:13:43", "2026-11-21T24:00:01",
                    "2026-11-21T24:00:00.5", "2026-11-21T23:60:00", "2026-11-21T23:59:60",
                    "2026-11-21T03:13:43.", "2026-11-21T03:13:43.Z", "2026-11-21T03:13:43+5:30",
                    "2026-11-21T03:13:43+14:01", "2026-11-21T03:13:43+05:60",
                    "2026-11-21T03:13:43ZZ", "2026-11-21T03:13:43 ", " 2026-11-21T03:13:43",
                    "-2026-11-21T03:13:43", "12026-11-21T03:13:43", "1969-12-31T23:59:59Z",
                    "+026-11-21T03:13:43", "2026-+1-21T03:13:43"));

TEST(DateTime, EveryPartOfOne_IsRefused) {
  const std::string whole = "2026-11-21T03:13:43+05:30";
  for (std::size_t size = 0; size < whole.size(); ++size) {
    if (size == 19) continue;  // has no zone
    EXPECT_EQ(read(whole.substr(0, size)), "refused") << size;
  }
}

TEST(DateTime, CycloneDds_HasNoMidnightOf24NoFarZonesAndNoLateYears) {
  const auto is_read_alike_by_cyclonedds = [](std::string_view text) {
    return parse_date_time(text, Round::down)->is_read_alike_by_cyclonedds;
  };
  for (const auto* text : {"2026-11-21T23:59:59Z", "2026-11-21T00:00:00", "2026-11-21T00:00:00.5Z",
                           "2026-11-21T00:00:00+12:00", "2026-11-21T00:00:00-12:00",
                           "2262-04-11T23:47:15Z", "1970-01-01T00:00:00Z"})
    EXPECT_TRUE(is_read_alike_by_cyclonedds(text)) << text;
  for (const auto* text :
       {"2026-11-21T24:00:00Z", "2026-11-21T00:00:00+14:00", "2026-11-21T00:00:00-12:01",
        "2262-04-11T23:47:17Z", "9999-12-31T23:59:59Z"})
    EXPECT_FALSE(is_read_alike_by_cyclonedds(text)) << text;
}

}  // namespace
}  // namespace ddssec::governance
