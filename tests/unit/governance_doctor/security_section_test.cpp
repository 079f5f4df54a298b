// The reader of <Security> alone. The behaviour of Cyclone DDS was measured in
// effective_security_test.
#include "governance/doctor/security_section.hpp"

#include <string_view>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ddssec::governance::doctor {
namespace {

using ::testing::HasSubstr;

// Reads a text with one or more <Security>, all of which apply.
EffectiveSecurity read(std::string_view text) {
  EffectiveSecurity out;
  ConfigurationFindings findings(out);
  OpenElements elements;
  SecuritySection section(out, findings, 0);
  Markup markup(text, text.npos);
  const auto end = [&] {
    section.on_end(elements);
    elements.close();
  };
  for (auto token = markup.next(); token.kind != Markup::Kind::end; token = markup.next()) {
    if (token.kind == Markup::Kind::text) section.on_text(token);
    if (token.kind == Markup::Kind::close) end();
    if (token.kind != Markup::Kind::open) continue;
    elements.open(token);
    section.is_open() ? section.on_start_tag(elements, token) : section.begin(elements, token);
    if (token.is_closed) end();
  }
  EXPECT_FALSE(section.is_open());
  return out;
}

TEST(SecuritySection, Values_AreStoredWithoutBlanksAround) {
  const auto out = read(
      "<Security><AccessControl><Library path=\"a\"/><Governance> file:/g\n</Governance>"
      "</AccessControl></Security>");
  EXPECT_TRUE(out.problems.empty());
  ASSERT_TRUE(out.applies && out.access_control);
  EXPECT_EQ(out.access_control->attribute("path")->text, "a");
  EXPECT_EQ(out.access_control->value("governance")->text, "file:/g");
  EXPECT_FALSE(out.authentication);
}

TEST(SecuritySection, UnknownElements_AreProblems) {
  for (const auto* text :
       {"<Security><Accounting/></Security>",
        "<Security><Cryptographic><Library/><Crl/></Cryptographic></Security>",
        "<Security><Authentication><Crl><Url/></Crl></Authentication></Security>"}) {
    const auto out = read(text);
    ASSERT_EQ(out.problems.size(), 1u) << text;
    EXPECT_THAT(out.problems[0].text, HasSubstr("inside <Security>"));
  }
}

TEST(SecuritySection, ElementsInAnUnknownPlugin_AreNotReportedToo) {
  EXPECT_EQ(read("<Security><Accounting><A/><B/></Accounting></Security>").problems.size(), 1u);
}

TEST(SecuritySection, WhatComesTwice_IsAProblem) {
  for (const auto* text :
       {"<Security><Cryptographic/><Cryptographic/></Security>",
        "<Security><Authentication><Crl>a</Crl><Crl>b</Crl></Authentication></Security>",
        "<Security><Cryptographic><Library path=\"a\"/><Library/></Cryptographic></Security>",
        "<Security><Cryptographic><Library path=\"a\" path=\"b\"/></Cryptographic></Security>"})
    EXPECT_EQ(read(text).problems.size(), 1u) << text;
}

TEST(SecuritySection, SecondSecurity_ReplacesTheFirst) {
  const auto out = read(
      "<Security><Authentication/><AccessControl/></Security>"
      "<Security><Authentication/></Security>");
  EXPECT_TRUE(out.problems.empty());
  EXPECT_TRUE(out.authentication);
  EXPECT_FALSE(out.access_control);
}

TEST(SecuritySection, SecondSecurityWithoutAuthentication_IsAProblem) {
  const auto out =
      read("<Security><Authentication/></Security><Security><AccessControl/></Security>");
  ASSERT_EQ(out.problems.size(), 1u);
  EXPECT_THAT(out.problems[0].text, HasSubstr("without <Authentication>"));
}

TEST(SecuritySection, IncludeOptionalFields_IsTrueOrFalse) {
  const auto problems = [](const std::string& value) {
    return read("<Security><Authentication><IncludeOptionalFields>" + value +
                "</IncludeOptionalFields></Authentication></Security>")
        .problems.size();
  };
  EXPECT_EQ(problems("true"), 0u);
  EXPECT_EQ(problems("FALSE"), 0u);
  EXPECT_EQ(problems(""), 0u);
  EXPECT_EQ(problems("1"), 1u);
}

}  // namespace
}  // namespace ddssec::governance::doctor
