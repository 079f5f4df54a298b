// Values that products read differently.
#include <gmock/gmock.h>

#include "doctor_fixture.hpp"
#include "governance/doctor/diagnosis.hpp"

namespace ddssec::governance::doctor {
namespace {

using testing::HasSubstr;

using DiagnosisTest = Folders;

TEST_F(DiagnosisTest, OpenRange_IsOneDomainToStockProducts) {
  const auto domain_five = [&](const Governance& governance) {
    const auto grant = grant_for("CN=talker", "Square", 5);
    const auto folder = participant("talker", governance, {.grants = {grant}});
    std::string xml = to_xml(governance);
    const std::string end = "<max>230</max>";
    xml.erase(xml.find(end), end.size());
    sign(folder.governance, xml);
    return diagnose(load_folder(folder, kNow), {.now = kNow, .domain = 5});
  };
  auto governance = strict_governance();
  governance.domain_rules[0].domains.ranges = {{0, 230}};
  auto all = domain_five(governance);
  EXPECT_THAT(finding_of(all, Rule::DOC050).message, HasSubstr("no <domain_rule>"));
  EXPECT_EQ(all.outcomes(), (Outcomes{.cyclonedds = Outcome::fail, .fastdds = Outcome::late}));

  governance.domain_rules.push_back(strict_governance(5).domain_rules[0]);
  all = domain_five(governance);
  EXPECT_THAT(finding_of(all, Rule::DOC050).message, HasSubstr("the <domain_rule> at line"));
  EXPECT_EQ(all.outcomes(), (Outcomes{.cyclonedds = Outcome::unsafe, .fastdds = Outcome::unsafe}));
}

}  // namespace
}  // namespace ddssec::governance::doctor
