#include "governance/doctor/diagnosis.hpp"

#include <gmock/gmock.h>

#include "fixture.hpp"

namespace ddssec::governance::doctor {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

using DiagnosisTest = Folders;

TEST_F(DiagnosisTest, ACorrectFolderPassesEveryCheck) {
  const auto all = diagnosis(participant("talker"));
  EXPECT_THAT(rules_of(all), IsEmpty());
  EXPECT_TRUE(all.outcomes().all_ok());
  EXPECT_GT(all.checks().size(), 20u);
}

TEST_F(DiagnosisTest, AnEmptyFolderLacksEverySingleFile) {
  const auto folder = pki::participant_folder(root_ / "empty", pki::FolderLayout::flat);
  fs::create_directories(folder.folder);
  const auto loaded = load_folder(folder, kNow);
  EXPECT_TRUE(loaded.is_empty());
  EXPECT_FALSE(load_folder(participant("talker"), kNow).is_empty());
  const auto all = diagnose(loaded, {.now = kNow});
  EXPECT_THAT(rules_of(all), ElementsAre(Rule::DOC001, Rule::DOC001, Rule::DOC001, Rule::DOC001,
                                         Rule::DOC001, Rule::DOC001));
  EXPECT_EQ(all.outcomes(), Outcomes::all(Outcome::fail));
}

TEST_F(DiagnosisTest, FaultsOfEveryPieceAreFoundTogether) {
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

TEST_F(DiagnosisTest, VendorsAreNamedOnlyIfTheyDiffer) {
  auto grant = grant_for("CN=talker");
  grant.default_allow = true;
  const auto all = diagnosis(participant("talker", strict_governance(), {.grants = {grant}}));
  EXPECT_THAT(finding_of(all, Rule::DOC052).vendors, ElementsAre("fastdds@2.9.1"));
  EXPECT_EQ(all.outcomes(), (Outcomes{.fastdds = Outcome::late}));
  auto nothing = grant;
  nothing.rules.clear();
  EXPECT_EQ(diagnosis(participant("talker", strict_governance(), {.grants = {nothing}})).outcomes(),
            (Outcomes{.fastdds = Outcome::fail}));
}

TEST_F(DiagnosisTest, TruncatedFilesAreFaultsAndNoCrash) {
  const auto folder = participant("talker");
  for (const auto& path : {folder.identity_ca, folder.certificate, folder.key,
                           folder.permissions_ca, folder.governance, folder.permissions}) {
    const auto whole = read(path);
    for (const std::size_t size : {whole.size() / 2, std::size_t{40}, std::size_t{1}}) {
      write(path, whole.substr(0, size));
      EXPECT_FALSE(diagnosis(folder).outcomes().all_ok()) << path << ' ' << size;
    }
    write(path, whole);
  }
  EXPECT_TRUE(diagnosis(folder).outcomes().all_ok());
}

TEST_F(DiagnosisTest, DenyFirstMattersOnlyWhereOneDirectionIsAllowed) {
  const auto with_deny = [&](bool publish, bool subscribe) {
    auto grant = grant_for("CN=talker", "rt/*");
    governance::Rule deny{.allow = false, .domains = {.ranges = {{0, 0}}}};
    if (publish) deny.publish.push_back({.topics = {{"rt/cmd*"}}});
    if (subscribe) deny.subscribe.push_back({.topics = {{"rt/cmd*"}}});
    grant.rules.insert(grant.rules.begin(), {{.allow = true, .domains = deny.domains}, deny});
    return diagnosis(participant("talker", strict_governance(), {.grants = {grant}}));
  };
  EXPECT_THAT(rules_of(with_deny(true, true)), IsEmpty());
  const auto all = with_deny(false, true);
  EXPECT_THAT(finding_of(all, Rule::DOC053).message, HasSubstr("publish topic \"rt/cmd\""));
  EXPECT_EQ(all.outcomes(), (Outcomes{.cyclonedds = Outcome::late}));
}

// Measured with Cyclone DDS 0.10.2 and Fast DDS 2.9.1, by pairs in the partitions "", "p" and "q".
TEST_F(DiagnosisTest, DenialInOnePartition_StockProductsRefuseTheTopicInAll) {
  const auto with_deny = [&](bool is_first) {
    auto grant = grant_for("CN=talker", "rt/*");
    governance::Rule deny{.allow = false, .domains = {.ranges = {{0, 0}}}};
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
TEST_F(DiagnosisTest, ADenialOfEverythingAsTheFirstRuleKeepsOurParticipantOut) {
  auto grant = grant_for("CN=talker");
  grant.rules.insert(grant.rules.begin(), {.allow = false, .domains = {.ranges = {{0, 0}}}});
  const auto all = diagnosis(participant("talker", strict_governance(), {.grants = {grant}}));
  EXPECT_THAT(finding_of(all, Rule::DOC051).message, HasSubstr("without topics closes domain 0"));
  EXPECT_EQ(all.outcomes(), (Outcomes{.ours = Outcome::fail}));
}

TEST_F(DiagnosisTest, ADenialOfTopicsAsTheFirstRuleKeepsNobodyOut) {
  auto grant = grant_for("CN=talker");
  grant.rules.insert(grant.rules.begin(), {.allow = false,
                                           .domains = {.ranges = {{0, 0}}},
                                           .publish = {{.topics = {{"Circle"}}}},
                                           .subscribe = {{.topics = {{"Circle"}}}}});
  const auto all = diagnosis(participant("talker", strict_governance(), {.grants = {grant}}));
  EXPECT_TRUE(all.outcomes().all_ok());
}

TEST_F(DiagnosisTest, StockProductsReadAnOpenRangeAsOneDomain) {
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

TEST_F(DiagnosisTest, ADenialWithAnOpenRangeDoesNotHoldWithStockProducts) {
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

TEST_F(DiagnosisTest, TheJoinRuleCountsOnlyWhereItIsAskedFor) {
  auto governance = strict_governance();
  const Permissions elsewhere{.grants = {grant_for("CN=talker", "Square", 5)}};
  EXPECT_EQ(diagnosis(participant("talker", governance, elsewhere)).outcomes(),
            (Outcomes{Outcome::fail, Outcome::late, Outcome::fail}));
  governance.domain_rules[0].enable_join_access_control = false;
  EXPECT_TRUE(diagnosis(participant("talker", governance, elsewhere)).outcomes().all_ok());
}

}  // namespace
}  // namespace ddssec::governance::doctor
