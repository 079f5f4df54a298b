#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/governance_compare/permissions_fixture.hpp"

namespace ddssec::governance {
namespace {

using ::testing::ElementsAre;
using ::testing::SizeIs;
using enum ChangeClass;
using namespace of_permissions;

// A change of the rules and its verdict, with a witness if a topic is wider or narrower.
struct Row {
  const char* name;
  std::vector<GrantRule> before, after;
  ChangeClass verdict;
  std::string narrower_at = "-", wider_at = "-";
};
void PrintTo(const Row& row, std::ostream* out) { *out << row.name; }

class RuleChanges : public ::testing::TestWithParam<Row> {};

TEST_P(RuleChanges, EachChange_GrowsOrShrinksTheSet) {
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

GrantRule in_domains(GrantRule rule, std::vector<DomainRange> ranges) {
  rule.domains.ranges = std::move(ranges);
  return rule;
}
GrantRule with_partitions(GrantRule rule, std::vector<Text> partitions) {
  rule.publish[0].partitions = std::move(partitions);
  return rule;
}

const std::vector<GrantRule> kCmdDeniedLate = {allow({{"rt/*"}}), deny({{"rt/cmd*"}})};

INSTANTIATE_TEST_SUITE_P(
    Table, RuleChanges,
    ::testing::Values(
        Row{"nothing", kAll, kAll, neutral},
        Row{"a deny before the allow", kAll, kCmdDenied, narrower, "rt/cmd"},
        Row{"the deny is taken away", kCmdDenied, kAll, wider, "-", "rt/cmd"},
        Row{"the deny moves behind the allow", kCmdDenied, kCmdDeniedLate, wider, "-", "rt/cmd"},
        Row{"a deny that hits nothing allowed",
            kAll,
            {join(), deny({{"rq/*"}}), allow({{"rt/*"}})},
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
            {join(), deny({{"rt/cmd*"}}), allow({{"rt/*"}}), allow({{"rt/cmd1"}})},
            neutral},
        Row{"another order without overlap",
            {allow({{"a*"}}), deny({{"b*"}})},
            {join(), deny({{"b*"}}), allow({{"a*"}})},
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
        // A deny rule without partitions applies to every partition, and one with partitions only
        // to those.
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

TEST(PermissionsDiff, TheDefault_HasALineOfItsOwn) {
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

TEST(PermissionsDiff, TheDefault_ComesFirst) {
  auto before = document({allow({{"rt/*"}})}), after = document({deny({{"rt/x"}})});
  after.grants[0].default_allow = true;
  const auto diff = compare(before, after);
  EXPECT_EQ(diff.verdict, mixed);
  ASSERT_THAT(diff.changes, SizeIs(2));
  EXPECT_EQ(diff.changes[0].element, "default");
  EXPECT_EQ(diff.changes[1].witness, "rt/x");
  EXPECT_EQ(diff.changes[1].change, narrower);
}

TEST(PermissionsDiff, ALongerValidity_IsWiderInTime) {
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

TEST(PermissionsDiff, ARenewal_IsComparedThoughItsTimesDoNotMeet) {
  const auto before = document(kAll);
  auto after = document(kCmdDenied);
  after.grants[0].validity = {at(500), at(600)};
  const auto diff = compare(before, after);
  EXPECT_EQ(diff.verdict, mixed);
  ASSERT_THAT(diff.changes, SizeIs(2));
  EXPECT_EQ(diff.changes[0].element, "validity");
  EXPECT_EQ(diff.changes[1].witness, "rt/cmd");
}

TEST(PermissionsDiff, AddedAndRemovedGrants_AreWiderAndNarrower) {
  const auto before = document(kAll);
  auto after = before;
  after.grants.push_back(grant_for("CN=other", kCmdDenied));
  auto diff = compare(before, after);
  EXPECT_EQ(diff.verdict, wider);
  ASSERT_THAT(diff.changes, SizeIs(3));
  EXPECT_EQ(diff.changes[0].subject, "CN=other");
  EXPECT_EQ(diff.changes[0].element, "grant");
  EXPECT_EQ(diff.changes[1].element, "join");
  EXPECT_EQ(diff.changes[2].element, "rule") << "and what it allows";
  EXPECT_THAT(diff.changes[2].expressions_new, ElementsAre("rt/*"));
  EXPECT_THAT(diff.changes[2].topics.words,
              ElementsAre(TopicWords{.expression = "rt/*", .except = {"rt/cmd*"}}));
  diff = compare(after, before);
  EXPECT_EQ(diff.verdict, narrower);
  EXPECT_EQ(diff.changes[0].new_value, "absent");

  // Any grant lets a participant use what the governance document leaves open.
  after.grants[1] = grant_for("CN=other", {deny({{"*"}})});
  EXPECT_EQ(compare(before, after).verdict, wider);
  after.grants[1].validity = {at(5), at(5)};
  EXPECT_EQ(compare(before, after).verdict, neutral) << "it is never valid";
}

TEST(PermissionsDiff, ASecondGrantOfASubject_IsNeutral) {
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
  // The second grant applies after the first one has ended.
  after.grants[1].validity = {at(100), at(300)};
  EXPECT_EQ(compare(before, after).verdict, wider);
}

TEST(PermissionsDiff, ValiditiesASecondApart_HaveAHint) {
  const auto hint = [](int from, int to) {
    auto after = document(kAll);
    after.grants[0].validity = {at(from), at(to)};
    const auto diff = compare(document(kAll), after);
    return diff.changes.at(0).hint;
  };
  EXPECT_THAT(hint(101, 200), ::testing::HasSubstr("one second apart"));
  EXPECT_THAT(hint(100, 199), ::testing::HasSubstr("one second apart"));
  EXPECT_EQ(hint(102, 202), "");
}

TEST(PermissionsDiff, JoiningADomain_IsARight) {
  const auto before = document(kAll);
  auto after = before;
  // Nothing can be published there, but topics without access control can be used.
  after.grants[0].rules.push_back({.allow = true, .domains = {.ranges = {{7, 7}}}});
  const auto diff = compare(before, after);
  EXPECT_EQ(diff.verdict, wider);
  ASSERT_THAT(diff.changes, SizeIs(1));
  EXPECT_EQ(diff.changes[0].element, "join");
  EXPECT_THAT(diff.changes[0].scope.domains, ElementsAre(DomainRange{7, 7}));
}

TEST(PermissionsDiff, Relaying_IsARight) {
  const auto before = document(kAll);
  auto after = before;
  after.grants[0].rules[0].relay = {{.topics = {{"rt/x"}}}};
  const auto diff = compare(before, after);
  EXPECT_EQ(diff.verdict, wider);
  ASSERT_THAT(diff.changes, SizeIs(1));
  EXPECT_EQ(diff.changes[0].operation, "relay");
  EXPECT_EQ(diff.changes[0].witness, "rt/x");
  EXPECT_EQ(compare(after, before).verdict, narrower);
  EXPECT_EQ(compare(after, after).verdict, neutral);
}

TEST(PermissionsDiff, DataTags_AreComparedAsSets) {
  const auto before = document(kAll);
  auto after = before;
  after.grants[0].rules[0].publish[0].data_tags = {{{"level", "secret"}}};
  auto diff = compare(before, after);
  EXPECT_EQ(diff.verdict, wider) << "an allow rule takes endpoints without tags besides";
  ASSERT_THAT(diff.changes, SizeIs(1));
  EXPECT_FALSE(diff.changes[0].entities.partitions) << "only endpoints with the tag";
  EXPECT_THAT(diff.changes[0].entities.example_data_tags, ElementsAre(DataTag{"level", "secret"}));
  const auto denied = document({deny({{"rt/*"}}), kAll[0]});
  auto tagged = denied;
  tagged.grants[0].rules[0].publish[0].data_tags = {{{"level", "secret"}}};
  diff = compare(denied, tagged);
  EXPECT_EQ(diff.verdict, wider) << "a deny rule with tags hits only endpoints that have one";
}

// Rules for domain tags are compared tag by tag.
TEST(PermissionsDiff, DomainTags_AreToldApart) {
  const auto before = document(kAll);
  auto after = before;
  after.grants[0].rules.push_back(allow({{"*"}}));
  after.grants[0].rules[1].domains = {.ranges = {{0, 230}}, .tag_expressions = {{"?*"}}};
  const auto diff = compare(before, after);
  EXPECT_EQ(diff.verdict, wider);
  ASSERT_THAT(diff.changes, SizeIs(2));
  for (const auto& change : diff.changes) {
    EXPECT_THAT(change.scope.domains, ElementsAre(DomainRange{0, 230}));
    EXPECT_EQ(change.scope.tags.form, NameSet::Form::listed);
    EXPECT_THAT(change.scope.tags.expressions, ElementsAre("?*"));
  }
}

// DDS-Security 1.2 table 70.
TEST(PermissionsDiff, ADenialOfEverythingInFront_RefusesToJoin) {
  GrantRule nothing = join();
  nothing.allow = false;
  const auto before = document({nothing, allow({{"a"}})});
  const auto diff = compare(before, document({allow({{"a"}})}));
  EXPECT_EQ(diff.verdict, wider);
  ASSERT_THAT(diff.changes, SizeIs(1));
  EXPECT_EQ(diff.changes[0].element, "join");
  EXPECT_EQ(diff.changes[0].old_value, "denied");
}

// A change says in which partitions it applies.
TEST(PermissionsDiff, Partitions_AreToldAsASet) {
  const auto before = document(kAll);
  const auto after = document({with_partitions(kAll[0], {{"*"}})});
  const auto diff = compare(before, after);
  ASSERT_THAT(diff.changes, SizeIs(1));
  ASSERT_TRUE(diff.changes[0].entities.partitions);
  EXPECT_EQ(diff.changes[0].entities.partitions->form, NameSet::Form::every_but);
  EXPECT_THAT(diff.changes[0].entities.partitions->expressions, ElementsAre(""));
}

TEST(PermissionsDiff, ManyPartitions_AreStillCompared) {
  std::vector<Text> partitions;
  for (int i = 0; i < 60; ++i) partitions.push_back({"p" + std::to_string(i)});
  const auto before = document({with_partitions(kAll[0], partitions)});
  partitions.pop_back();
  const auto diff = compare(before, document({with_partitions(kAll[0], partitions)}));
  EXPECT_EQ(diff.verdict, narrower);
  EXPECT_TRUE(diff.is_exact);
  ASSERT_THAT(diff.changes, SizeIs(1));
  EXPECT_THAT(diff.changes[0].entities.partitions->expressions, ElementsAre("p59"));
}

TEST(PermissionsDiff, MoreKindsOfEndpointsThanCanBeTried_AreUnknown) {
  std::vector<GrantRule> rules;
  for (int i = 0; i < 12; ++i)
    rules.push_back(
        with_partitions(deny({{"t" + std::to_string(i)}}), {{"p" + std::to_string(i)}}));
  rules.push_back(with_partitions(allow({{"*"}}), {{"*"}}));
  auto changed = rules;
  changed.pop_back();
  changed.push_back(with_partitions(allow({{"*"}}), {{"*"}, {""}}));
  const auto diff = compare(document(rules), document(changed));
  EXPECT_FALSE(diff.is_exact);
  EXPECT_EQ(diff.verdict, unknown) << "no gate lets it pass";
}

TEST(PermissionsDiff, QuestionTooHard_IsUnknown) {
  const auto tail = std::string(12, '?');
  const auto diff = compare(document({deny({{"*a" + tail}}), allow({{"*"}})}),
                            document({deny({{"*[ab]" + tail}}), allow({{"*"}})}));
  EXPECT_EQ(diff.verdict, unknown);
  ASSERT_THAT(diff.changes, SizeIs(1));
  EXPECT_EQ(diff.changes[0].change, unknown);
}

}  // namespace
}  // namespace ddssec::governance
