// Findings of lint about what only some products refuse or read differently in a permissions
// document.
#include <optional>

#include "governance/lint.hpp"
#include "governance/rights.hpp"
#include "governance/write.hpp"
#include "tests/unit/governance/governance_fixture.hpp"

namespace ddssec::governance {
namespace {

using Vendors = std::vector<std::string>;

const pki::Certificate& certificate() {
  static const auto made = make_leaf(pki::make_ca(), "CN=talker").certificate;
  return made;
}

std::string document() {
  return to_xml({.grants = {grant_of("talker", certificate(),
                                     {.domains = {{0, 0}}, .publish = {"a"}, .subscribe = {}},
                                     {certificate().not_before(), certificate().not_after()})}});
}

// Returns the document with `to` in place of what stands between the two texts.
std::string with(std::string_view before, std::string_view after, std::string_view to) {
  auto xml = document();
  const auto from = xml.find(before) + before.size();
  return xml.replace(from, xml.find(after, from) - from, to);
}

std::optional<Finding> finding(ddssec::Rule rule, const std::string& xml,
                               const PermissionsUse& use = {}) {
  const auto read = permissions_from(xml);
  EXPECT_TRUE(read) << read.error().to_sentence();
  for (auto& one : lint(*read, use))
    if (one.rule == rule) return one;
  return std::nullopt;
}

TEST(LintPermissionsProducts, SubjectBetweenLineBreaks_FastDdsDoesNotRecogniseIt) {
  const auto xml = with("<subject_name>", "</subject_name>", "\n  CN=talker\n  ");
  for (const auto* own : {static_cast<const pki::Certificate*>(nullptr), &certificate()}) {
    const auto found = finding(ddssec::Rule::PERM011, xml, {.certificate = own});
    ASSERT_TRUE(found);
    EXPECT_EQ(found->products, Vendors{"fastdds"});
    EXPECT_NE(found->message.find("between line breaks"), std::string::npos);
  }
}

TEST(LintPermissionsProducts, EndThatCycloneDdsReadsAsPast_IsNamed) {
  for (const char* end : {"2263-01-01T00:00:00Z", "9999-01-01T00:00:00Z", "2037-01-01T24:00:00Z"}) {
    const auto found = finding(ddssec::Rule::PERM002, with("<not_after>", "</not_after>", end));
    ASSERT_TRUE(found) << end;
    EXPECT_EQ(found->products, Vendors{"cyclonedds"});
    EXPECT_EQ(found->severity, Severity::warning);
  }
  EXPECT_FALSE(
      finding(ddssec::Rule::PERM002, with("<not_after>", "</not_after>", "2262-01-01T00:00:00Z")));
}

TEST(LintPermissionsProducts, DenyRuleWithoutTopics_ClosesTheDomainToDdssecAlone) {
  const std::string denial = "<deny_rule><domains><id>0</id></domains></deny_rule>";
  auto first = document(), last = first;
  first.insert(first.find("<allow_rule>"), denial);
  const auto found = finding(ddssec::Rule::PERM027, first);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->products, (Vendors{"cyclonedds", "fastdds"}));
  EXPECT_NE(found->message.find("closes domain 0"), std::string::npos);
  last.insert(last.find("<default>"), denial);
  EXPECT_FALSE(finding(ddssec::Rule::PERM027, last));
  auto elsewhere = document();
  elsewhere.insert(elsewhere.find("<allow_rule>"),
                   "<deny_rule><domains><id>5</id></domains></deny_rule>");
  EXPECT_FALSE(finding(ddssec::Rule::PERM027, elsewhere));
}

}  // namespace
}  // namespace ddssec::governance
