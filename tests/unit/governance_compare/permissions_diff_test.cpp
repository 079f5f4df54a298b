#include "governance/compare/permissions_diff.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ddssec::governance {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using enum ChangeClass;

WallTime at(int seconds) { return WallTime(std::chrono::seconds(seconds)); }

/// A rule about publishing in domain 0.
Rule rule(bool allow, std::vector<Text> topics) {
  Rule rule{.allow = allow};
  rule.domains.ranges = {{0, 0}};
  rule.publish = {{.topics = std::move(topics)}};
  return rule;
}
Rule allow(std::vector<Text> topics) { return rule(true, std::move(topics)); }
Rule deny(std::vector<Text> topics) { return rule(false, std::move(topics)); }

Permissions document(std::vector<Rule> rules) {
  Grant grant{.name = "g", .subject_name = "CN=talker,O=Acme", .validity = {at(100), at(200)}};
  grant.rules = std::move(rules);
  grant.line = 3;
  Permissions permissions;
  permissions.grants = {grant};
  return permissions;
}

/// What a change of the rules is, with the witness where something is wider or narrower.
struct Row {
  const char* name;
  std::vector<Rule> before, after;
  ChangeClass verdict;
  std::string narrower_at = "-", wider_at = "-";
};
void PrintTo(const Row& row, std::ostream* out) { *out << row.name; }

class RuleChanges : public ::testing::TestWithParam<Row> {};

TEST_P(RuleChanges, AreSetsThatGrowOrShrink) {
  const auto& row = GetParam();
  const auto diff = compare(document(row.before), document(row.after));
  EXPECT_EQ(diff.verdict, row.verdict);
  const auto witness = [&](ChangeClass kind) {
    for (const auto& change : diff.changes) {
      if (change.change == kind && change.element == "rule") return change.witness;
    }
    return std::string("-");
  };
  EXPECT_EQ(witness(narrower), row.narrower_at);
  EXPECT_EQ(witness(wider), row.wider_at);
}

Rule in_domains(Rule rule, std::vector<DomainRange> ranges) {
  rule.domains.ranges = std::move(ranges);
  return rule;
}
Rule with_partitions(Rule rule, std::vector<Text> partitions) {
  rule.publish[0].partitions = std::move(partitions);
  return rule;
}

const std::vector<Rule> kCmdDenied = {deny({{"rt/cmd*"}}), allow({{"rt/*"}})};
const std::vector<Rule> kCmdDeniedLate = {allow({{"rt/*"}}), deny({{"rt/cmd*"}})};
const std::vector<Rule> kAll = {allow({{"rt/*"}})};

INSTANTIATE_TEST_SUITE_P(
    Table, RuleChanges,
    ::testing::Values(
        Row{"nothing", kAll, kAll, neutral},
        Row{"a deny before the allow", kAll, kCmdDenied, narrower, "rt/cmd"},
        Row{"the deny is taken away", kCmdDenied, kAll, wider, "-", "rt/cmd"},
        Row{"the deny moves behind the allow", kCmdDenied, kCmdDeniedLate, wider, "-", "rt/cmd"},
        Row{"a deny that hits nothing allowed",
            kAll,
            {deny({{"rq/*"}}), allow({{"rt/*"}})},
            neutral},
        Row{"another expression",
            {allow({{"rt/a*"}})},
            {allow({{"rt/*z"}})},
            mixed,
            "rt/a",
            "rt/z"},
        Row{"an expression more", kAll, {allow({{"rt/*"}, {"rq/x"}})}, wider, "-", "rq/x"},
        Row{"an allow rule more", kAll, {allow({{"rt/*"}}), allow({{"rq/x"}})}, wider, "-", "rq/x"},
        Row{"what is allowed already", kAll, {allow({{"rt/*"}, {"rt/x"}})}, neutral},
        Row{"what an earlier deny hits",
            kCmdDenied,
            {deny({{"rt/cmd*"}}), allow({{"rt/*"}}), allow({{"rt/cmd1"}})},
            neutral},
        Row{"another order without overlap",
            {allow({{"a*"}}), deny({{"b*"}})},
            {deny({{"b*"}}), allow({{"a*"}})},
            neutral},
        Row{"in other words", {allow({{"rt/[ab]*"}})}, {allow({{"rt/a*"}, {"rt/b*"}})}, neutral},
        Row{"more domains", kAll, {in_domains(kAll[0], {{0, 5}})}, wider, "-", "rt/"},
        Row{"fewer domains", {in_domains(kAll[0], {{0, 5}})}, kAll, narrower, "rt/"},
        Row{"domains in other words",
            {in_domains(kAll[0], {{0, 5}})},
            {in_domains(kAll[0], {{3, 5}, {0, 2}})},
            neutral},
        Row{"partitions where there were none",
            kAll,
            {with_partitions(kAll[0], {{"p"}})},
            mixed,
            "rt/",
            "rt/"},
        Row{"partitions and the default one",
            kAll,
            {with_partitions(kAll[0], {{""}, {"p"}})},
            wider,
            "-",
            "rt/"},
        Row{"a partition more",
            {with_partitions(kAll[0], {{"p"}})},
            {with_partitions(kAll[0], {{"p"}, {"q"}})},
            wider,
            "-",
            "rt/"},
        Row{"partitions in other words",
            {with_partitions(kAll[0], {{"[pq]"}})},
            {with_partitions(kAll[0], {{"p"}, {"q"}})},
            neutral},
        // A deny rule without partitions hits every partition, one with them only those.
        Row{"a deny for one partition only",
            {deny({{"rt/x"}}), with_partitions(kAll[0], {{"*"}})},
            {with_partitions(deny({{"rt/x"}}), {{"p"}}), with_partitions(kAll[0], {{"*"}})},
            wider,
            "-",
            "rt/x"},
        // Two rules that each allow one partition do not allow an entity with both.
        Row{"one rule for two partitions",
            {with_partitions(kAll[0], {{"p"}}), with_partitions(kAll[0], {{"q"}})},
            {with_partitions(kAll[0], {{"p"}, {"q"}})},
            wider,
            "-",
            "rt/"}));

TEST(PermissionsDiff, TheDefaultHasALineOfItsOwn) {
  auto before = document({allow({{"rt/*"}})}), after = document({allow({{"rt/[!x]*"}})});
  after.grants[0].default_allow = true;
  const auto diff = compare(before, after);
  EXPECT_EQ(diff.verdict, wider);
  ASSERT_THAT(diff.changes, SizeIs(1));
  EXPECT_EQ(diff.changes[0].element, "default");
  EXPECT_EQ(diff.changes[0].old_value, "DENY");
  EXPECT_EQ(diff.changes[0].new_value, "ALLOW");
  const auto back = compare(after, before);
  EXPECT_EQ(back.verdict, narrower);
  EXPECT_EQ(back.changes[0].element, "default");
}

TEST(PermissionsDiff, TheDefaultComesFirst) {
  auto before = document({allow({{"rt/*"}})}), after = document({deny({{"rt/x"}})});
  after.grants[0].default_allow = true;
  const auto diff = compare(before, after);
  EXPECT_EQ(diff.verdict, mixed);
  ASSERT_THAT(diff.changes, SizeIs(2));
  EXPECT_EQ(diff.changes[0].element, "default");
  EXPECT_EQ(diff.changes[1].witness, "rt/x");
  EXPECT_EQ(diff.changes[1].change, narrower);
}

TEST(PermissionsDiff, ALongerValidityIsWiderInTime) {
  const auto before = document(kAll);
  auto after = before;
  after.grants[0].validity = {at(100), at(300)};
  auto diff = compare(before, after);
  EXPECT_EQ(diff.verdict, wider);
  ASSERT_THAT(diff.changes, SizeIs(1));
  EXPECT_EQ(diff.changes[0].element, "validity");
  EXPECT_EQ(diff.changes[0].new_value, "1970-01-01T00:01:40Z .. 1970-01-01T00:05:00Z");
  EXPECT_EQ(compare(after, before).verdict, narrower);
  after.grants[0].validity = {at(50), at(200)};
  EXPECT_EQ(compare(before, after).verdict, wider);
  after.grants[0].validity = {at(50), at(150)};
  EXPECT_EQ(compare(before, after).verdict, mixed);
}

TEST(PermissionsDiff, ARenewalIsComparedThoughItsTimesDoNotMeet) {
  const auto before = document(kAll);
  auto after = document(kCmdDenied);
  after.grants[0].validity = {at(500), at(600)};
  const auto diff = compare(before, after);
  EXPECT_EQ(diff.verdict, mixed);
  ASSERT_THAT(diff.changes, SizeIs(2));
  EXPECT_EQ(diff.changes[0].element, "validity");
  EXPECT_EQ(diff.changes[1].witness, "rt/cmd");
}

Grant grant_for(std::string subject, std::vector<Rule> rules) {
  auto grant = document(std::move(rules)).grants[0];
  grant.subject_name = std::move(subject);
  return grant;
}

TEST(PermissionsDiff, GrantsComeAndGo) {
  const auto before = document(kAll);
  auto after = before;
  after.grants.push_back(grant_for("CN=other", kCmdDenied));
  auto diff = compare(before, after);
  EXPECT_EQ(diff.verdict, wider);
  ASSERT_THAT(diff.changes, SizeIs(1));
  EXPECT_EQ(diff.changes[0].subject, "CN=other");
  EXPECT_EQ(diff.changes[0].element, "grant");
  EXPECT_THAT(diff.changes[0].expressions_new, ElementsAre("rt/*"));
  diff = compare(after, before);
  EXPECT_EQ(diff.verdict, narrower);
  EXPECT_EQ(diff.changes[0].new_value, "absent");

  after.grants[1] = grant_for("CN=other", {deny({{"*"}})});
  EXPECT_EQ(compare(before, after).verdict, neutral) << "nothing is allowed by it";
}

TEST(PermissionsDiff, ASecondGrantOfASubjectIsNeutral) {
  const auto before = document(kCmdDenied);
  auto after = before;
  after.grants.push_back(grant_for("O=Acme,CN=talker", kAll));
  after.grants[1].line = 40;
  const auto diff = compare(before, after);
  EXPECT_EQ(diff.verdict, neutral);
  ASSERT_THAT(diff.changes, SizeIs(1));
  EXPECT_EQ(diff.changes[0].element, "grant");
  EXPECT_EQ(diff.changes[0].change, neutral);
  EXPECT_EQ(diff.changes[0].new_line, 40);
  // After the first one has ended it applies.
  after.grants[1].validity = {at(100), at(300)};
  EXPECT_EQ(compare(before, after).verdict, wider);
}

TEST(PermissionsDiff, ASubjectInOtherWordsIsInterop) {
  const auto before = document(kAll);
  auto after = before;
  for (const char* text : {"O=Acme, CN=talker", "CN=talker, O=Acme", "/O=Acme/CN=talker"}) {
    after.grants[0].subject_name = text;
    const auto diff = compare(before, after);
    EXPECT_EQ(diff.verdict, neutral) << text;
    ASSERT_THAT(diff.changes, SizeIs(1));
    EXPECT_EQ(diff.changes[0].element, "subject_name");
    EXPECT_EQ(diff.changes[0].change, interop);
  }
  after.grants[0].subject_name = "CN=Talker,O=Acme";
  EXPECT_EQ(compare(before, after).verdict, mixed) << "somebody else";
}

TEST(PermissionsDiff, SubjectsCanBeMappedByTheNameOfTheirGrant) {
  const auto before = document(kAll);
  auto after = document(kCmdDenied);
  after.grants[0].subject_name = "CN=talker2";
  EXPECT_EQ(compare(before, after).verdict, mixed);
  auto diff = compare(before, after, {.map_subjects_by_grant_name = true});
  EXPECT_EQ(diff.verdict, narrower);
  ASSERT_THAT(diff.changes, SizeIs(2));
  EXPECT_EQ(diff.changes[1].element, "subject_name");
  EXPECT_EQ(diff.changes[1].old_value, "CN=talker,O=Acme");
  EXPECT_EQ(diff.changes[1].new_value, "CN=talker2");
  after.grants.push_back(grant_for("CN=talker3", kAll));
  diff = compare(before, after, {.map_subjects_by_grant_name = true});
  EXPECT_EQ(diff.verdict, mixed) << "two grants have the name";
}

TEST(PermissionsDiff, JoiningADomainIsARight) {
  const auto before = document(kAll);
  auto after = before;
  // Nothing can be published there, but topics without access control can be used.
  after.grants[0].rules.push_back(in_domains(deny({{"*"}}), {{7, 7}}));
  after.grants[0].rules.push_back(in_domains(allow({{"rt/x"}}), {{7, 7}}));
  const auto diff = compare(before, after);
  EXPECT_EQ(diff.verdict, wider);
  ASSERT_THAT(diff.changes, SizeIs(1));
  EXPECT_EQ(diff.changes[0].element, "join");
  EXPECT_THAT(diff.changes[0].domains, ElementsAre(DomainRange{7, 7}));
}

TEST(PermissionsDiff, RelaysAndDataTagsAreComparedByTheirText) {
  const auto before = document(kAll);
  auto after = before;
  after.grants[0].rules[0].relay = {{.topics = {{"rt/x"}}}};
  auto diff = compare(before, after);
  EXPECT_EQ(diff.verdict, unknown);
  EXPECT_EQ(diff.changes[0].element, "relay");
  EXPECT_EQ(compare(after, after).verdict, neutral);

  after = before;
  after.grants[0].rules[0].publish[0].data_tags = {{{"level", "secret"}}};
  diff = compare(before, after);
  EXPECT_EQ(diff.verdict, unknown);
  EXPECT_EQ(diff.changes[0].element, "data_tags");
  EXPECT_EQ(compare(after, after).verdict, neutral);
}

TEST(PermissionsDiff, ExpressionsOfSubjectsAlsoCoverNamedOnes) {
  auto before = document(kAll);
  before.grants.push_back(grant_for("CN=*", kAll));
  before.grants[1].subject_is_expression = true;
  auto after = before;
  after.grants.erase(after.grants.begin());
  after.grants[0].subject_name = "CN=*,O=Acme";
  before.grants[1].subject_name = "CN=*,O=Acme";
  const auto diff = compare(before, after);
  EXPECT_EQ(diff.verdict, neutral) << "the talker still has the grant for everybody";
  after.grants[0].rules = kCmdDenied;
  EXPECT_EQ(compare(before, after).verdict, narrower);
}

TEST(PermissionsDiff, MoreKindsOfPartitionsThanCanBeTriedAreTriedByTwo) {
  std::vector<Text> partitions;
  for (int i = 0; i < 12; ++i) partitions.push_back({"p" + std::to_string(i)});
  const auto before = document({with_partitions(kAll[0], partitions)});
  partitions.pop_back();
  const auto after = document({with_partitions(kAll[0], partitions)});
  const auto diff = compare(before, after);
  EXPECT_EQ(diff.verdict, narrower);
  EXPECT_FALSE(diff.is_exact);
  EXPECT_THAT(diff.changes[0].partitions, Contains("p11"));
}

TEST(PermissionsDiff, WhatIsTooHardIsUnknown) {
  const auto tail = std::string(12, '?');
  const auto diff = compare(document({deny({{"*a" + tail}}), allow({{"*"}})}),
                            document({deny({{"*[ab]" + tail}}), allow({{"*"}})}));
  EXPECT_EQ(diff.verdict, unknown);
  ASSERT_THAT(diff.changes, SizeIs(1));
  EXPECT_EQ(diff.changes[0].change, unknown);
}

TEST(PermissionsDiff, ASubjectThatIsNoNameIsNobody) {
  auto before = document(kAll), after = document(kAll);
  after.grants.push_back(grant_for("no name", kAll));
  EXPECT_EQ(compare(before, after).verdict, neutral);
  EXPECT_THAT(compare(before, after).changes, IsEmpty());
}

}  // namespace
}  // namespace ddssec::governance
