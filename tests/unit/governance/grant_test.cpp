#include "governance/grant.hpp"

#include "tests/unit/governance/governance_fixture.hpp"

namespace ddssec::governance {
namespace {

using namespace std::chrono_literals;
using pki::kNow;

Grant grant_for(std::string subject, bool expression = false) {
  Grant grant;
  grant.subject_name = std::move(subject);
  grant.subject_is_expression = expression;
  grant.validity = {kNow - 1h, kNow + 1h};
  return grant;
}

pki::SubjectName name(std::string_view text) {
  auto parsed = pki::SubjectName::parse(text);
  EXPECT_TRUE(parsed);
  return *parsed;
}

struct Row {
  const char* grant;
  bool expression;
  bool matches;
};
void PrintTo(const Row& row, std::ostream* out) { *out << row.grant; }

class SubjectRow : public testing::TestWithParam<Row> {};
TEST_P(SubjectRow, EachRow_IsAsTheStandardSays) {
  EXPECT_EQ(is_for(grant_for(GetParam().grant, GetParam().expression),
                   name("CN=talker 1,O=Example,C=DE")),
            GetParam().matches);
}
INSTANTIATE_TEST_SUITE_P(Names, SubjectRow,
                         testing::Values(Row{"CN=talker 1,O=Example,C=DE", false, true},
                                         Row{"C=DE, O = Example, CN=talker 1", false, true},
                                         Row{"/C=DE/O=Example/CN=talker 1", false, true},
                                         Row{"CN=\\74alker 1,O=Example,C=DE", false, true},
                                         Row{"CN=talker 1,O=Example", false, false},
                                         Row{"CN=talker 1,O=Example,C=DE,OU=x", false, false},
                                         Row{"CN=Talker 1,O=Example,C=DE", false, false},
                                         Row{"CN=Example,O=talker 1,C=DE", false, false},
                                         Row{"O=Example,CN=talker 1,C=DE", false, false},
                                         Row{"CN=talker 1+O=Example,C=DE", false, false},
                                         Row{"CN=*,O=Example,C=DE", false, false},
                                         Row{"gibberish", false, false}, Row{"", false, false}));
INSTANTIATE_TEST_SUITE_P(Expressions, SubjectRow,
                         testing::Values(Row{"CN=talker*,O=Example,C=DE", true, true},
                                         Row{"C=D?,O=[E]xample,CN=*", true, true},
                                         Row{"CN=listener*,O=Example,C=DE", true, false},
                                         Row{"CN=*,O=Example", true, false},
                                         Row{"O=Example,CN=talker*,C=DE", true, false},
                                         Row{"CN=talker*+O=Example,C=DE", true, false},
                                         Row{"CN=*,O=*,C=*,OU=*", true, false},
                                         Row{"*=*", true, false}));

TEST(SubjectExpression, Slash_IsNotCrossed) {
  const auto grant = grant_for("CN=talker*", true);
  EXPECT_TRUE(is_for(grant, name("CN=talker1")));
  EXPECT_FALSE(is_for(grant, name("CN=talker/1")));
}

TEST(FindGrant, SeveralGrants_TheFirstValidOneIsTaken) {
  Permissions document;
  document.grants = {grant_for("CN=other"), grant_for("CN=me"), grant_for("CN=me"),
                     grant_for("CN=me")};
  document.grants[1].validity = {kNow - 2h, kNow};
  const auto found = find_grant(document, name("CN=me"), "CN=me", kNow);
  ASSERT_TRUE(found);
  EXPECT_EQ(*found, &document.grants[2]);
}

TEST(FindGrant, Validity_BeginsWithNotBeforeAndEndsBeforeNotAfter) {
  Permissions document;
  document.grants = {grant_for("CN=me")};
  const auto at = [&](WallTime now) { return find_grant(document, name("CN=me"), "CN=me", now); };
  EXPECT_CODE(at(kNow - 1h - 1s), grant_not_yet_valid);
  EXPECT_TRUE(at(kNow - 1h));
  EXPECT_TRUE(at(kNow + 1h - 1s));
  EXPECT_CODE(at(kNow + 1h), grant_expired);
}

TEST(ValidAt, SeveralGrants_TheFirstValidOneIsTaken) {
  const Grant early{.validity = {WallTime{10s}, WallTime{20s}}};
  const Grant late{.validity = {WallTime{15s}, WallTime{30s}}};
  const std::vector<const Grant*> grants = {&early, &late};
  EXPECT_EQ(valid_at(grants, WallTime{9s}), nullptr);
  EXPECT_EQ(valid_at(grants, WallTime{15s}), &early);
  EXPECT_EQ(valid_at(grants, WallTime{20s}), &late);
  EXPECT_EQ(valid_at(grants, WallTime{30s}), nullptr);
}

TEST(FindGrant, SubjectWithoutAGrant_IsShownTheSubjectsThatHaveOne) {
  Permissions document;
  for (int i = 0; i < 5; ++i) document.grants.push_back(grant_for("CN=p" + std::to_string(i)));
  const auto found = find_grant(document, name("CN=me"), "CN=me", kNow);
  EXPECT_CODE(found, no_grant_for_subject);
  EXPECT_EQ(found.error().details().expected, "CN=me");
  EXPECT_EQ(found.error().details().found, "CN=p0 | CN=p1 | CN=p2 | and 2 more");
}

}  // namespace
}  // namespace ddssec::governance
