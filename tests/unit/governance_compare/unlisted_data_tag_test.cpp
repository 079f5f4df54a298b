// Endpoints with a data tag that no rule lists: allow rules do not apply to them, deny rules do.
#include <gtest/gtest.h>

#include "governance/compare/permissions_diff.hpp"
#include "governance/read.hpp"

namespace ddssec::governance {
namespace {

constexpr std::string_view kAllowEverythingUntagged = R"(
    <allow_rule><domains><id>0</id></domains>
      <publish><topics><topic>*</topic></topics><partitions><partition>*</partition></partitions></publish>
    </allow_rule>)";

std::string deny(const std::string& topic) {
  return "<deny_rule><domains><id>0</id></domains><publish><topics><topic>" + topic +
         "</topic></topics></publish></deny_rule>";
}

Permissions permissions(const std::string& rules, const std::string& default_action) {
  const auto xml =
      "<dds><permissions><grant name='g'><subject_name>CN=a</subject_name><validity>"
      "<not_before>2026-01-01T00:00:00</not_before><not_after>2027-01-01T00:00:00"
      "</not_after></validity>" +
      std::string(kAllowEverythingUntagged) + rules + "<default>" + default_action +
      "</default></grant></permissions></dds>";
  return read_permissions(as_bytes(xml)).value();
}

TEST(UnlistedDataTag, DenyRuleIsRemoved_WiderThoughTheAllowRuleListsEveryTopic) {
  const auto diff = compare(permissions(deny("b"), "ALLOW"), permissions("", "ALLOW"));
  EXPECT_EQ(diff.verdict, ChangeClass::wider);
  ASSERT_EQ(diff.changes.size(), 1U);
  EXPECT_EQ(diff.changes[0].operation, "publish");
  EXPECT_EQ(diff.changes[0].witness, "b");
  EXPECT_EQ(diff.changes[0].entities.example_data_tags.size(), 1U);
}

TEST(UnlistedDataTag, DenyRuleIsForAnotherTopic_Mixed) {
  EXPECT_EQ(compare(permissions(deny("b"), "ALLOW"), permissions(deny("c"), "ALLOW")).verdict,
            ChangeClass::mixed);
}

TEST(UnlistedDataTag, DefaultDeniesAnyway_Neutral) {
  EXPECT_EQ(compare(permissions(deny("b"), "DENY"), permissions("", "DENY")).verdict,
            ChangeClass::neutral);
}

}  // namespace
}  // namespace ddssec::governance
