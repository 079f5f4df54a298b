#include "base/finding.hpp"

#include <set>

#include <gtest/gtest.h>

namespace ddssec {
namespace {

TEST(Rule, EveryRow_IsAtItsPlaceWithATitleAndAHint) {
  std::set<std::string_view> ids;
  for (const auto& row : all_rules()) {
    EXPECT_EQ(&info(row.rule), &row) << row.id;
    EXPECT_TRUE(ids.insert(row.id).second) << row.id;
    EXPECT_FALSE(row.title.empty()) << row.id;
    EXPECT_FALSE(row.hint.empty()) << row.id;
  }
  EXPECT_EQ(all_rules().size(), static_cast<std::size_t>(Rule::end_));
}

TEST(Rule, EachRule_HasItsIdAsName) { EXPECT_EQ(info(Rule::GOV012).id, "GOV012"); }

TEST(Finding, FindingWithoutASeverityOfItsOwn_HasThatOfItsRule) {
  const Finding usual{.rule = Rule::PERM012, .message = "x"};
  EXPECT_EQ(usual.severity, info(Rule::PERM012).severity);
  const Finding other{.rule = Rule::PERM012, .message = "x", .severity = Severity::error};
  EXPECT_EQ(other.severity, Severity::error);
}

}  // namespace
}  // namespace ddssec
