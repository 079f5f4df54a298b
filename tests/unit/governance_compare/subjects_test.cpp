// Which grants of two documents are for the same participants.
#include "governance/compare/subjects.hpp"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/governance_compare/permissions_fixture.hpp"

namespace ddssec::governance {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;
using enum ChangeClass;
using namespace of_permissions;

TEST(PermissionsDiff, ASubjectInOtherWords_IsInterop) {
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
  EXPECT_EQ(compare(before, after).verdict, mixed) << "another participant";
}

// An expression without wildcards can only mean the same name.
TEST(PermissionsDiff, ASubjectAsAnExpressionWithoutWildcards_IsTheSame) {
  const auto before = document(kAll);
  auto after = before;
  after.grants[0].subject_is_expression = true;
  auto diff = compare(before, after);
  EXPECT_EQ(diff.verdict, neutral);
  ASSERT_THAT(diff.changes, SizeIs(1));
  EXPECT_EQ(diff.changes[0].element, "subject_name");
  EXPECT_EQ(diff.changes[0].change, interop);
  after.grants[0].subject_name = "O=Acme,CN=talker";
  EXPECT_EQ(compare(before, after).verdict, neutral) << "backwards";
  after.grants[0].subject_name = "CN=talke[r],O=Acme";
  EXPECT_EQ(compare(before, after).verdict, neutral) << "one subject all the same";
  after.grants[0].subject_name = "CN=talke?,O=Acme";
  diff = compare(before, after);
  EXPECT_EQ(diff.verdict, wider);
  EXPECT_EQ(diff.changes[0].element, "grant");
  EXPECT_EQ(diff.changes[0].subject, "CN=talke?,O=Acme");
  EXPECT_EQ(compare(after, before).verdict, narrower);
}

TEST(PermissionsDiff, ASubjectAsAnotherExpressionForTheSame_IsInterop) {
  struct Case {
    const char *old_name, *new_name;
    bool old_is_expression = true, is_the_same = true;
  };
  for (const auto& [old_name, new_name, old_is_expression, is_the_same] :
       {Case{"CN=a", "CN=[a]", false}, Case{"CN=a", "CN=[a-a]"}, Case{"CN=*", "CN=**"},
        Case{"CN=?*", "CN=*?"}, Case{"CN=a*,O=x", "O=[x],CN=a**"}, Case{"CN=[ab]", "CN=[b-ba]"},
        Case{"CN=a*", "CN=[a]?*", true, false}, Case{"CN=a", "CN=[ab]", false, false}}) {
    auto before = document(kAll), after = document(kAll);
    before.grants[0].subject_name = old_name;
    before.grants[0].subject_is_expression = old_is_expression;
    after.grants[0].subject_name = new_name;
    after.grants[0].subject_is_expression = true;
    const auto diff = compare(before, after);
    EXPECT_EQ(diff.verdict == neutral, is_the_same) << new_name;
    const auto lines = std::ranges::count(diff.changes, "subject_name", &PermissionChange::element);
    EXPECT_EQ(lines, is_the_same ? 1 : 0) << old_name << " -> " << new_name;
  }
}

// Expressions match with FNM_PATHNAME and FNM_NOESCAPE (DDS-Security 1.2, clause 10.4.1.5.3.2.1).
TEST(PermissionsDiff, ExpressionsOfSubjects_AreComparedAsSets) {
  const auto verdict = [](const char* old_name, std::vector<const char*> new_names) {
    auto before = document(kAll), after = document(kAll);
    before.grants[0].subject_is_expression = true;
    before.grants[0].subject_name = old_name;
    const auto any = before.grants[0];
    after.grants.clear();
    for (const char* name : new_names) {
      after.grants.push_back(any);
      after.grants.back().subject_name = name;
    }
    const auto diff = compare(before, after);
    EXPECT_TRUE(diff.is_exact);
    return diff.verdict;
  };
  EXPECT_EQ(verdict("CN=[ab]*", {"CN=a*", "CN=b*"}), neutral);
  EXPECT_EQ(verdict("CN=*", {"CN=a*"}), narrower);
  EXPECT_EQ(verdict("CN=*", {"CN=*", "CN=*/*"}), wider) << "a star does not take a slash";
  EXPECT_EQ(verdict("CN=*", {"CN=[!/]*"}), narrower) << "a slash in brackets matches nothing";
  EXPECT_EQ(verdict("CN=a\\\\*", {"CN=a\\\\*"}), neutral);
  EXPECT_EQ(verdict("CN=a*,O=x", {"CN=*b,O=x"}), mixed);
  EXPECT_EQ(verdict("CN=a*,O=x", {"O=x,CN=a*"}), neutral) << "backwards";
  EXPECT_EQ(verdict("CN=a*,CN=b", {"CN=b,CN=a*"}), neutral) << "backwards, of one shape";
  EXPECT_EQ(verdict("CN=a*+OU=x", {"OU=x+CN=a*"}), neutral) << "an RDN is a set";
}

TEST(PermissionsDiff, Subjects_CanBeMappedByTheNameOfTheirGrant) {
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
  EXPECT_EQ(diff.changes[1].change, ChangeClass::neutral) << "it is another subject";
  after.grants.push_back(grant_for("CN=talker3", kAll));
  diff = compare(before, after, {.map_subjects_by_grant_name = true});
  EXPECT_EQ(diff.verdict, mixed) << "two grants have the name";
}

TEST(PermissionsDiff, AnExpression_IsNoRenamedParticipant) {
  const auto before = document(kAll);
  for (const auto* expression : {"CN=*,O=*", "CN=*", "CN=*,O=*,C=*", "CN=talker,OU=*"}) {
    auto after = before;
    after.grants[0].subject_name = expression;
    after.grants[0].subject_is_expression = true;
    const auto forward = compare(before, after, {.map_subjects_by_grant_name = true});
    EXPECT_TRUE(forward.verdict == wider || forward.verdict == mixed) << expression;
    const auto back = compare(after, before, {.map_subjects_by_grant_name = true});
    EXPECT_TRUE(back.verdict == narrower || back.verdict == mixed) << expression;
  }
}

TEST(PermissionsDiff, ExpressionsOfSubjects_CoverNamedOnesToo) {
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

TEST(PermissionsDiff, SubjectThatIsNoName_MatchesNoParticipant) {
  auto before = document(kAll), after = document(kAll);
  after.grants.push_back(grant_for("no name", kAll));
  EXPECT_EQ(compare(before, after).verdict, neutral);
  EXPECT_THAT(compare(before, after).changes, IsEmpty());
}

}  // namespace
}  // namespace ddssec::governance
