// Findings about validity, second grants, defaults, names and spelling.
#include "tests/unit/governance/permissions_lint.hpp"

namespace ddssec::governance {
namespace {

TEST(LintPermissions, RightsOfItsCertificate_HaveNoFindings) {
  const auto document = with(rights({"a", "b*"}, {"c"}));
  EXPECT_TRUE(lint_but_joining(document).empty());
  const auto governance = governance_of(Profile::strict, {{0, 0}});
  EXPECT_TRUE(lint_but_joining(document, {pki::kNow, &certificate(), &governance}).empty());
}

TEST(LintPermissions, DatesOutsideTheCertificates_AreFound) {
  const auto document = with(rights({"a"}));
  const auto ended = only(document, {.now = certificate().not_after()});
  EXPECT_EQ(ended.rule, ddssec::Rule::PERM002);
  EXPECT_EQ(ended.severity, Severity::error);
  const auto early = only(document, {.now = certificate().not_before() - std::chrono::seconds(1)});
  EXPECT_EQ(early.rule, ddssec::Rule::PERM002);
  EXPECT_EQ(early.severity, Severity::warning);
  const auto longer = changed([](Grant& g) { g.validity.not_after += std::chrono::hours(1); });
  EXPECT_EQ(only(longer, {.certificate = &certificate()}).rule, ddssec::Rule::PERM002);
  EXPECT_TRUE(lint_but_joining(longer).empty());
}

TEST(LintPermissions, ValidityOfASecondOrLess_IsFound) {
  using std::chrono::seconds;
  const auto lasting = [](seconds time) {
    return changed([&](Grant& g) { g.validity.not_after = g.validity.not_before + time; });
  };
  const auto never = only(lasting(seconds(0)));
  EXPECT_EQ(never.rule, ddssec::Rule::PERM002);
  EXPECT_EQ(never.severity, Severity::error);
  EXPECT_TRUE(never.message.starts_with("the grant is never valid: it begins and ends at "));
  const auto once = only(lasting(seconds(1)));
  EXPECT_EQ(once.severity, Severity::warning);
  EXPECT_TRUE(once.message.starts_with("the grant is valid for one second only, at "));
  EXPECT_TRUE(lint_but_joining(lasting(seconds(2))).empty());
}

TEST(LintPermissions, ASecondGrant_IsDead) {
  auto grant = grant_for(rights({"a"}));
  auto other = grant;
  other.subject_name = "C=DE, O=\"A, B\", CN=talker";
  auto found = lint_but_joining(read_again({.grants = {grant, other}}));
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].rule, ddssec::Rule::PERM011);
  EXPECT_EQ(found[1].rule, ddssec::Rule::PERM010);
  EXPECT_EQ(found[1].severity, Severity::error);
  EXPECT_EQ(found[1].path, "/dds/permissions/grant[2]");
  other.subject_name = "CN=listener";
  EXPECT_TRUE(lint_but_joining(read_again({.grants = {grant, other}})).empty());
}

TEST(LintPermissions, GrantAfterAnExpressionForItsSubject_IsDead) {
  auto many = grant_for(rights({"a"}));
  const auto one = many;
  many.subject_is_expression = true;
  const auto dead = [&](std::string expression) {
    many.subject_name = std::move(expression);
    auto found = lint(read_again({.grants = {many, one}}));
    std::erase_if(found, [](const Finding& f) { return f.rule != ddssec::Rule::PERM010; });
    return found;
  };
  const auto found = dead("CN=talke?, O=*, C=DE");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].severity, Severity::error);
  EXPECT_EQ(found[0].path, "/dds/permissions/grant[2]");
  EXPECT_NE(found[0].message.find("\"CN=talke?, O=*, C=DE\" in line"), std::string::npos)
      << found[0].message;
  EXPECT_TRUE(dead("CN=listene?, O=*, C=DE").empty());
  many.validity = {one.validity.not_after, one.validity.not_after + std::chrono::hours(1)};
  EXPECT_TRUE(dead("CN=talke?, O=*, C=DE").empty());
}

TEST(LintPermissions, ARenewedGrant_IsDeadForCycloneOnly) {
  auto grant = grant_for(rights({"a"}));
  auto next = grant;
  next.validity = {grant.validity.not_after, grant.validity.not_after + std::chrono::hours(1)};
  const auto found = only(read_again({.grants = {grant, next}}));
  EXPECT_EQ(found.rule, ddssec::Rule::PERM010);
  EXPECT_EQ(found.severity, Severity::warning);
  EXPECT_EQ(found.products, std::vector<std::string>{"cyclonedds"});
}

TEST(LintPermissions, DefaultsAndGrantsThatAllowNothing_AreFound) {
  EXPECT_EQ(only(changed([](Grant& g) { g.default_allow = true; })).rule, ddssec::Rule::PERM022);
  EXPECT_EQ(only(with_rules({rule(false, {"a"})})).rule, ddssec::Rule::PERM023);
}

TEST(LintPermissions, NamesThatATerminalShowsInAnotherWay_AreFound) {
  const auto topic = only(with(rights({"Square\xe2\x80\xae", "Circle"})));
  EXPECT_EQ(topic.rule, ddssec::Rule::PERM041);
  EXPECT_NE(topic.message.find("holds U+202E"), std::string::npos) << topic.message;
  const auto partition = only(changed([](Grant& grant) {
    grant.rules.at(0).publish.at(0).partitions = {
        {Text{"\xc2\x9b"
              "2J",
              0}}};
  }));
  EXPECT_NE(partition.message.find("the partition"), std::string::npos);
  EXPECT_NE(partition.message.find("U+009B"), std::string::npos);
  EXPECT_EQ(only(changed([](Grant& grant) { grant.name = "a\xe2\x80\x8f"; })).rule,
            ddssec::Rule::PERM041);
  EXPECT_TRUE(lint_but_joining(with(rights({"Stra\xc3\x9f"
                                            "e"})))
                  .empty());
}

struct Spelling {
  const char *from, *to;
  ddssec::Rule id;
};
class SpellingOfPermissions : public ::testing::TestWithParam<Spelling> {};

TEST_P(SpellingOfPermissions, EachSpelling_IsFoundAtItsLine) {
  const auto& [from, to, id] = GetParam();
  const auto xml = to_xml(Permissions{.grants = {grant_for(rights({"a"}))}});
  const auto document = permissions_from(replaced(xml, from, to));
  ASSERT_TRUE(document) << document.error().to_sentence();
  EXPECT_EQ(only(*document).rule, id);
}

INSTANTIATE_TEST_SUITE_P(
    All, SpellingOfPermissions,
    ::testing::Values(Spelling{"<default>DENY</default>", "", ddssec::Rule::PERM001},
                      Spelling{" name=\"talker\"", "", ddssec::Rule::PERM001},
                      Spelling{"Z</not_after>", "</not_after>", ddssec::Rule::PERM003},
                      Spelling{"<id>0</id>", "<id_range><max>0</max></id_range>",
                               ddssec::Rule::PERM004},
                      Spelling{">a<", ">a <", ddssec::Rule::PERM005},
                      Spelling{"<id>0</id>", "<id>0</id><tag></tag>", ddssec::Rule::PERM006}));

}  // namespace
}  // namespace ddssec::governance
