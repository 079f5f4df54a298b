// The dates of an identity.
#include <gmock/gmock.h>

#include "doctor_fixture.hpp"
#include "governance/doctor/diagnosis.hpp"
#include "tests/support/expect_code.hpp"

namespace ddssec::governance::doctor {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

using DiagnosisTest = Folders;

TEST_F(DiagnosisTest, WhatEndsFirst_IsSaidAMonthAhead) {
  const auto folder = participant("talker");
  const auto all = diagnosis(folder, kNow + 340 * 24h);
  EXPECT_THAT(rules_of(all), ElementsAre(Rule::DOC041));
  EXPECT_THAT(finding_of(all, Rule::DOC041).message, HasSubstr("in 25 d 0 h"));
  EXPECT_TRUE(all.outcomes().all_ok());
}

TEST_F(DiagnosisTest, DatesNearNow_DependOnTheTimeZone) {
  auto grant = grant_for("CN=talker");
  grant.validity.not_before = kNow - 2h;
  const auto all = diagnosis(participant("talker", strict_governance(), {.grants = {grant}}));
  EXPECT_THAT(rules_of(all), ElementsAre(Rule::DOC042));
}

// Such a file results when the renewed certificate of a CA is appended.
TEST_F(DiagnosisTest, EndedCertificateOfTheCaBeforeTheValidOne_HarmsNoParticipantOfOurs) {
  const auto folder = participant("talker");
  for (const pki::Validity other :
       {pki::Validity{kNow - 48h, kNow - 24h}, pki::Validity{kNow + 24h, kNow + 48h}}) {
    const auto not_valid = identity_ca_.renewed(other, test_random());
    ASSERT_OK(not_valid);
    write(folder.identity_ca, not_valid->pem() + identity_ca_.certificate().pem());
    EXPECT_EQ(diagnosis(folder).outcomes().ddssec, Outcome::ok)
        << testing::PrintToString(rules_of(diagnosis(folder)));
    write(folder.identity_ca, not_valid->pem());
    EXPECT_EQ(diagnosis(folder).outcomes().ddssec, Outcome::fail);
  }
}

}  // namespace
}  // namespace ddssec::governance::doctor
