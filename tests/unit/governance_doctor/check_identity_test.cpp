// Dates of an identity.
#include <gmock/gmock.h>

#include "fixture.hpp"
#include "governance/doctor/diagnosis.hpp"

namespace ddssec::governance::doctor {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

using DiagnosisTest = Folders;

TEST_F(DiagnosisTest, WhatEndsFirstIsSaidAMonthAhead) {
  const auto folder = participant("talker");
  const auto all = diagnosis(folder, kNow + 340 * 24h);
  EXPECT_THAT(rules_of(all), ElementsAre(Rule::DOC041));
  EXPECT_THAT(finding_of(all, Rule::DOC041).message, HasSubstr("in 25 d 0 h"));
  EXPECT_TRUE(all.outcomes().all_ok());
}

TEST_F(DiagnosisTest, DatesNearNowDependOnTheTimeZone) {
  auto grant = grant_for("CN=talker");
  grant.validity.not_before = kNow - 2h;
  const auto all = diagnosis(participant("talker", strict_governance(), {.grants = {grant}}));
  EXPECT_THAT(rules_of(all), ElementsAre(Rule::DOC042));
}

}  // namespace
}  // namespace ddssec::governance::doctor
