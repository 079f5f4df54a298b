// The right of a participant to join.
#include <gmock/gmock.h>

#include "doctor_fixture.hpp"
#include "governance/doctor/diagnosis.hpp"

namespace ddssec::governance::doctor {
namespace {

using DiagnosisTest = Folders;

TEST_F(DiagnosisTest, TheJoinRule_CountsOnlyWhereItIsAskedFor) {
  auto governance = strict_governance();
  const Permissions elsewhere{.grants = {grant_for("CN=talker", "Square", 5)}};
  EXPECT_EQ(diagnosis(participant("talker", governance, elsewhere)).outcomes(),
            (Outcomes{Outcome::fail, Outcome::late, Outcome::fail}));
  governance.domain_rules[0].enable_join_access_control = false;
  EXPECT_TRUE(diagnosis(participant("talker", governance, elsewhere)).outcomes().all_ok());
}

}  // namespace
}  // namespace ddssec::governance::doctor
