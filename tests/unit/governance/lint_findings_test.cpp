// How findings are collected, bounded and written.
#include "governance/lint_findings.hpp"

#include <gtest/gtest.h>

#include "governance/lint.hpp"

namespace ddssec::governance {
namespace {

using enum ddssec::Rule;

Finding at_line(int line, ddssec::Rule rule = PERM012) {
  return {.rule = rule, .message = "line " + std::to_string(line), .line = line};
}

TEST(Findings, SeveralLines_AreOrdered) {
  LintFindings findings(PERM012);
  for (const int line : {3, 1, 2}) findings.add(at_line(line));
  const auto all = findings.take();
  ASSERT_EQ(all.size(), 3u);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(all[static_cast<std::size_t>(i)].line, i + 1);
}

TEST(Findings, AboveTheLimitOfARule_AreCountedAtItsLastOne) {
  LintFindings findings(PERM012);
  const int most = static_cast<int>(kMaxFindingsPerRule);
  for (int line = 1; line <= most + 3; ++line) findings.add(at_line(line));
  findings.add(at_line(1, PERM013));
  const auto all = findings.take();
  ASSERT_EQ(all.size(), kMaxFindingsPerRule + 1);
  EXPECT_EQ(all.back().message, "line " + std::to_string(most) + " (and 3 more like this)");
  EXPECT_EQ(all.front().message.find("more like this"), std::string::npos);
}

TEST(Findings, PlacesOfANoteThatHaveNone_AreCountedToo) {
  LintFindings findings(PERM012);
  findings.add(PERM003, Note{.line = 7, .path = "/dds", .text = "no zone", .more = 40}, {kFastDds});
  const auto all = findings.take();
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].line, 7);
  EXPECT_EQ(all[0].products, std::vector<std::string>{"fastdds"});
  EXPECT_EQ(all[0].message,
            "no zone (and " + std::to_string(41 - kMaxFindingsPerRule) + " more like this)");
}

TEST(Findings, ChecksThatWereLeftOut_AreAWarning) {
  for (const auto effort : {&SetEffort::steps, &SetEffort::plain_steps}) {
    LintFindings findings(GOV012);
    findings.effort().*effort = 0;
    const auto all = findings.take();
    ASSERT_EQ(all.size(), 1u);
    EXPECT_EQ(all[0].rule, GOV012);
    EXPECT_EQ(all[0].severity, Severity::warning);
    EXPECT_NE(all[0].message.find("take too long to compare"), std::string::npos);
  }
}

TEST(Findings, NameThatBeginsWithASlash_IsReported) {
  LintFindings findings(PERM012);
  findings.add_if_ros_name(PERM034, {"rt/a", 1}, "/dds");
  findings.add_if_ros_name(PERM034, {"/a", 2}, "/dds");
  const auto all = findings.take();
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].line, 2);
}

TEST(Findings, NameThatATerminalShowsInAnotherWay_IsReportedWithTheCharacter) {
  LintFindings findings(PERM012);
  findings.add_if_misleading(PERM041, "the topic", {"a\xe2\x80\xae", 1}, "/dds");
  findings.add_if_misleading(PERM041, "the topic", {"a\xff", 2}, "/dds");
  findings.add_if_misleading(PERM041, "the topic", {"\xc3\xa4", 3}, "/dds");
  const auto all = findings.take();
  ASSERT_EQ(all.size(), 2u);
  EXPECT_TRUE(all[0].message.starts_with("the topic "));
  EXPECT_TRUE(all[0].message.ends_with(" holds U+202E"));
  EXPECT_TRUE(all[1].message.ends_with(" holds octets that are not UTF-8"));
}

TEST(FindingText, LongName_IsCut) {
  EXPECT_EQ(in_quotes("rt/a"), "\"rt/a\"");
  EXPECT_EQ(in_quotes(std::string(80, 'a')), '"' + std::string(80, 'a') + '"');
  EXPECT_EQ(in_quotes(std::string(81, 'a')), '"' + std::string(80, 'a') + "...\"");
}

TEST(FindingText, Domains_AreIdsAndRanges) {
  EXPECT_EQ(to_text({}), "");
  EXPECT_EQ(to_text({{3, 3}}), "3");
  EXPECT_EQ(to_text({{0, 5}, {7, 7}}), "0-5, 7");
}

TEST(FindingText, SubjectName_IsWrittenAsRfc2253Says) {
  const auto name = [](std::string_view text) { return pki::SubjectName::parse(text).value(); };
  EXPECT_EQ(rfc2253(name("CN=a,O=b"), false), "CN=a,O=b");
  EXPECT_EQ(rfc2253(name("CN=a,O=b"), true), "O=b,CN=a");
  EXPECT_EQ(rfc2253(name("CN=a\\,b\\+c,O=\\#d"), false), "CN=a\\,b\\+c,O=\\#d");
  EXPECT_EQ(rfc2253(name("CN=a+OU=b,O=c"), false), "CN=a+OU=b,O=c");
  EXPECT_EQ(rfc2253(name("CN=\\ a b\\ "), false), "CN=\\ a b\\ ");
}

TEST(HasErrors, ErrorAlone_Counts) {
  EXPECT_FALSE(has_errors({}));
  auto finding = at_line(1);
  finding.severity = Severity::warning;
  EXPECT_FALSE(has_errors({finding}));
  finding.severity = Severity::error;
  EXPECT_TRUE(has_errors({at_line(1, PERM003), finding}));
}

}  // namespace
}  // namespace ddssec::governance
