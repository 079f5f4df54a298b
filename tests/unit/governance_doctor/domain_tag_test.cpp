#include "governance/doctor/domain_tag.hpp"

#include <gmock/gmock.h>

#include "doctor_fixture.hpp"

namespace ddssec::governance::doctor {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(DomainTagOfAConfiguration, EachSpelling_IsFoundAsCycloneDdsReadsIt) {
  EXPECT_EQ(domain_tag_setting("<Discovery><Tag>Robots</Tag></Discovery>"), "Robots");
  EXPECT_EQ(domain_tag_setting("<CycloneDDS><DISCOVERY>\n<Ports/><tag> a b </></>"), "a b");
  EXPECT_EQ(domain_tag_setting("<Discovery/><Discovery><Tag>x</Tag></Discovery>"), "x");
  for (const auto* none :
       {"", "<CycloneDDS/>", "<Discovery><Tag></Tag></Discovery>",
        "<Discovery></Discovery><Tag>x</Tag>", "<Discovery><Tag>default</Tag></Discovery>",
        "<!-- <Discovery><Tag>x</Tag> -->", "<", "<Discovery><Tag"})
    EXPECT_EQ(domain_tag_setting(none), "") << none;
}

TEST(DomainTagOfAConfiguration, SetTag_IsWarnedOf) {
  Diagnosis none;
  diagnose_domain_tag("<CycloneDDS/>", "cyclonedds.xml", none);
  EXPECT_THAT(none.checks(), IsEmpty());
  Diagnosis out;
  diagnose_domain_tag("<Discovery><Tag>x</Tag></Discovery>", "a/cyclonedds.xml", out);
  EXPECT_THAT(rules_of(out), ElementsAre(Rule::DOC114));
  EXPECT_EQ(out.outcomes(), Outcomes{});
  const auto finding = finding_of(out, Rule::DOC114);
  EXPECT_EQ(finding.severity, Severity::warning);
  EXPECT_EQ(finding.document, "a/cyclonedds.xml");
  EXPECT_THAT(finding.message, HasSubstr("\"x\""));
}

}  // namespace
}  // namespace ddssec::governance::doctor
