// Differences that keep two participants apart from the start.
#include <gmock/gmock.h>

#include "doctor_fixture.hpp"
#include "governance/doctor/meeting.hpp"
#include "tests/unit/governance_doctor/meetings.hpp"

namespace ddssec::governance::doctor::meetings {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST_F(MeetingTest, EveryParticipantLevelElementThatDiffers_KeepsThemApart) {
  const auto with = [&](auto change) {
    auto governance = strict_governance();
    change(governance.domain_rules[0]);
    sign(listener_.governance, to_xml(governance));
    return meeting();
  };
  const auto rtps = with([](DomainRule& r) { r.rtps_protection_kind = ProtectionKind::encrypt; });
  EXPECT_THAT(findings(rtps), ElementsAre(Rule::DOC082));
  EXPECT_THAT(rtps.findings[0].message, HasSubstr("is SIGN at talker"));
  EXPECT_THAT(findings(with([](DomainRule& r) {
                r.discovery_protection_kind = ProtectionKind::sign;
                r.liveliness_protection_kind = ProtectionKind::none;
              })),
              ElementsAre(Rule::DOC082, Rule::DOC082));
  // Measured: the participants may differ in these two elements.
  EXPECT_THAT(findings(with([](DomainRule& r) { r.enable_join_access_control = false; })),
              IsEmpty());
  EXPECT_THAT(findings(with([](DomainRule& r) { r.allow_unauthenticated_participants = true; })),
              IsEmpty());
}

TEST_F(MeetingTest, AnEmptyFolder_IsAPeerWithoutSecurity) {
  fs::remove_all(listener_.folder);
  fs::create_directories(listener_.folder);
  EXPECT_THAT(findings(meeting()), ElementsAre(Rule::DOC087));
}

TEST_F(MeetingTest, ABrokenParticipant_IsNamedAndTheRestIsStillSaid) {
  sign(listener_.permissions, to_xml(Permissions{.grants = {grant_for("CN=somebody")}}));
  const auto out = meeting();
  EXPECT_THAT(findings(out), ElementsAre(Rule::DOC090, Rule::DOC081));
  EXPECT_FALSE(out.joined());
}

}  // namespace
}  // namespace ddssec::governance::doctor::meetings
