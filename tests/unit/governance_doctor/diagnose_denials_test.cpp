// Denials that products read differently.
#include <gmock/gmock.h>

#include "doctor_fixture.hpp"
#include "governance/doctor/diagnosis.hpp"

namespace ddssec::governance::doctor {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

using DiagnosisTest = Folders;

TEST_F(DiagnosisTest, DenyFirst_MattersOnlyWhereOneDirectionIsAllowed) {
  const auto with_deny = [&](bool publish, bool subscribe) {
    auto grant = grant_for("CN=talker", "rt/*");
    governance::GrantRule deny{.allow = false, .domains = {.ranges = {{0, 0}}}};
    if (publish) deny.publish.push_back({.topics = {{"rt/cmd*"}}});
    if (subscribe) deny.subscribe.push_back({.topics = {{"rt/cmd*"}}});
    grant.rules.insert(grant.rules.begin(), {{.allow = true, .domains = deny.domains}, deny});
    return diagnosis(participant("talker", strict_governance(), {.grants = {grant}}));
  };
  EXPECT_THAT(rules_of(with_deny(true, true)), IsEmpty());
  const auto all = with_deny(false, true);
  EXPECT_THAT(finding_of(all, Rule::DOC053).message, HasSubstr("publishing topic \"rt/cmd\""));
  EXPECT_EQ(all.outcomes(), (Outcomes{.cyclonedds = Outcome::late}));
}

// Measured with pairs of Cyclone DDS 0.10.2 and of Fast DDS 2.9.1 in the partitions "", "p" and
// "q".
TEST_F(DiagnosisTest, DenialInOnePartition_StockProductsRefuseTheTopicInAll) {
  const auto with_deny = [&](bool is_first) {
    auto grant = grant_for("CN=talker", "rt/*");
    governance::GrantRule deny{.allow = false, .domains = {.ranges = {{0, 0}}}};
    deny.publish.push_back({.topics = {{"rt/cmd"}}, .partitions = std::vector<Text>{{"p", 0}}});
    grant.rules.insert(is_first ? grant.rules.begin() : grant.rules.end(), deny);
    return diagnosis(participant("talker", strict_governance(), {.grants = {grant}}));
  };
  const auto all = with_deny(true);
  EXPECT_EQ(all.outcomes(), (Outcomes{.cyclonedds = Outcome::late, .fastdds = Outcome::late}));
  EXPECT_THAT(rules_of(all), Contains(Rule::DOC053));
  EXPECT_TRUE(with_deny(false).outcomes().all_ok());
}

// DDS-Security 1.2 table 70.
TEST_F(DiagnosisTest, ADenialOfEverythingAsTheFirstRule_KeepsOurParticipantOut) {
  auto grant = grant_for("CN=talker");
  grant.rules.insert(grant.rules.begin(), {.allow = false, .domains = {.ranges = {{0, 0}}}});
  const auto all = diagnosis(participant("talker", strict_governance(), {.grants = {grant}}));
  EXPECT_THAT(finding_of(all, Rule::DOC051).message, HasSubstr("without topics closes domain 0"));
  EXPECT_EQ(all.outcomes(), (Outcomes{.ddssec = Outcome::fail}));
}

TEST_F(DiagnosisTest, ADenialOfTopicsAsTheFirstRule_KeepsNoParticipantOut) {
  auto grant = grant_for("CN=talker");
  grant.rules.insert(grant.rules.begin(), {.allow = false,
                                           .domains = {.ranges = {{0, 0}}},
                                           .publish = {{.topics = {{"Circle"}}}},
                                           .subscribe = {{.topics = {{"Circle"}}}}});
  const auto all = diagnosis(participant("talker", strict_governance(), {.grants = {grant}}));
  EXPECT_TRUE(all.outcomes().all_ok());
}

TEST_F(DiagnosisTest, ADenialWithAnOpenRange_DoesNotHoldWithStockProducts) {
  auto grant = grant_for("CN=talker");
  grant.rules[0].domains.ranges = {{0, 230}};
  auto denial = grant.rules[0];
  denial.allow = false;
  grant.rules.insert(grant.rules.begin(), {.allow = true, .domains = {.ranges = {{0, 230}}}});
  grant.rules.insert(grant.rules.begin() + 1, denial);
  const auto in_domain = [&](DomainId domain) {
    const auto folder = participant("talker", strict_governance(domain), {.grants = {grant}});
    auto xml = to_xml(Permissions{.grants = {grant}});
    const std::string end = "<max>230</max>";
    xml.erase(xml.find(end, xml.find("<deny_rule>")), end.size());
    sign(folder.permissions, xml);
    return diagnose(load_folder(folder, kNow), {.now = kNow, .domain = domain});
  };
  const auto all = in_domain(5);
  EXPECT_EQ(all.outcomes().cyclonedds, Outcome::unsafe);
  const auto said = std::ranges::any_of(all.checks(), [](const Check& check) {
    return check.rule == Rule::DOC037 &&
           std::ranges::any_of(check.findings, [](const Finding& finding) {
             return finding.message.contains("does not hold in domain 5");
           });
  });
  EXPECT_TRUE(said);
  EXPECT_NE(in_domain(0).outcomes().cyclonedds, Outcome::unsafe);
}

}  // namespace
}  // namespace ddssec::governance::doctor
