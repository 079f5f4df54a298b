#include "base/code.hpp"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>

namespace ddssec {
namespace {

TEST(Code, EveryRow_HasItsOwnNumberASummaryAndAHint) {
  std::set<std::string_view> names;
  for (const auto& row : all_codes()) {
    EXPECT_GE(static_cast<int>(row.code), 1000) << row.name;
    EXPECT_FALSE(row.summary.empty()) << row.name;
    EXPECT_FALSE(row.hint.empty()) << row.name;
    EXPECT_EQ(&info(row.code), &row);
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
  }
}

TEST(Code, NumberThatNoRowHas_IsInternal) {
  EXPECT_EQ(info(Code{1}).code, Code::internal);
  EXPECT_EQ(info(Code{999'999'999}).code, Code::internal);
}

// The table has the text itself, so that docs/codes.md shows it.
TEST(Code, HintThatIsLeftOut_IsThatOfSeveralRows) {
  EXPECT_GT(std::ranges::count(all_codes(), kNoHint, &CodeInfo::hint), 5);
}

TEST(Code, Rows_AreSortedByNumber) {
  EXPECT_TRUE(std::ranges::is_sorted(all_codes(), {}, &CodeInfo::code));
}

TEST(Severity, EachValue_HasTheNameOfItsEnumerator) {
  EXPECT_EQ(to_string(Severity::debug), "debug");
  EXPECT_EQ(to_string(Severity::informational), "informational");
  EXPECT_EQ(to_string(Severity::critical), "critical");
}

}  // namespace
}  // namespace ddssec
