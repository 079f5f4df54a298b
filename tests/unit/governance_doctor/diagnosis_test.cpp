#include "governance/doctor/diagnosis.hpp"

#include <gmock/gmock.h>

#include "doctor_fixture.hpp"

namespace ddssec::governance::doctor {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

using DiagnosisTest = Folders;

TEST_F(DiagnosisTest, ACorrectFolder_PassesEveryCheck) {
  const auto all = diagnosis(participant("talker"));
  EXPECT_THAT(rules_of(all), IsEmpty());
  EXPECT_TRUE(all.outcomes().all_ok());
  EXPECT_GT(all.checks().size(), 20u);
}

TEST_F(DiagnosisTest, FaultsOfEveryPiece_AreFoundTogether) {
  auto governance = strict_governance(3);
  auto grant = grant_for("CN=talkre");
  const auto folder = participant("talker", governance, {.grants = {grant}});
  write(folder.key, read(participant("other").key));
  const auto all = diagnosis(folder);
  EXPECT_THAT(rules_of(all), ElementsAre(Rule::DOC012, Rule::DOC050, Rule::DOC010));
  EXPECT_EQ(all.outcomes(), Outcomes::all(Outcome::fail));
  EXPECT_THAT(finding_of(all, Rule::DOC010).message, HasSubstr("CN=talkre"));
  EXPECT_EQ(finding_of(all, Rule::DOC010).document, folder.permissions);
}

TEST_F(DiagnosisTest, Products_AreNamedOnlyIfTheyDiffer) {
  auto grant = grant_for("CN=talker");
  grant.default_allow = true;
  const auto all = diagnosis(participant("talker", strict_governance(), {.grants = {grant}}));
  EXPECT_THAT(finding_of(all, Rule::DOC052).products, ElementsAre("fastdds@2.9.1"));
  EXPECT_EQ(all.outcomes(), (Outcomes{.fastdds = Outcome::late}));
  auto nothing = grant;
  nothing.rules.clear();
  EXPECT_EQ(diagnosis(participant("talker", strict_governance(), {.grants = {nothing}})).outcomes(),
            (Outcomes{.fastdds = Outcome::fail}));
}

}  // namespace
}  // namespace ddssec::governance::doctor
