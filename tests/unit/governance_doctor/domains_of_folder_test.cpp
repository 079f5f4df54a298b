#include "governance/doctor/domains_of_folder.hpp"

#include "tests/unit/governance_doctor/doctor_fixture.hpp"

namespace ddssec::governance::doctor {
namespace {

class DomainsOfAFolder : public Folders {
 protected:
  Domains domains(Domains governed, Domains granted, bool default_allow = false) {
    auto governance = strict_governance();
    governance.domain_rules[0].domains.ranges = std::move(governed);
    auto grant = grant_for("CN=p");
    grant.rules[0].domains.ranges = std::move(granted);
    grant.default_allow = default_allow;
    return domains_of(load_folder(participant("p", governance, {.grants = {grant}}), kNow), kNow);
  }
};

TEST_F(DomainsOfAFolder, BothDocuments_GiveTheCommonOnes) {
  EXPECT_EQ(domains({{7, 7}}, {{7, 7}}), (Domains{{7, 7}}));
  EXPECT_EQ(domains({{0, 9}}, {{7, 20}}), (Domains{{7, 9}}));
  EXPECT_EQ(domains({{3, 4}, {0, 2}, {9, 9}}, {{0, 230}}), (Domains{{0, 4}, {9, 9}}));
}

TEST_F(DomainsOfAFolder, DocumentsWithoutCommonOnes_GiveOne) {
  EXPECT_EQ(domains({{1, 3}}, {{5, 6}}), (Domains{{1, 1}}));
  EXPECT_EQ(domains({{1, 3}}, {{0, 0}}), (Domains{{1, 1}}));
}

TEST_F(DomainsOfAFolder, ADefaultOfAllow_IsForAllDomains) {
  EXPECT_EQ(domains({{4, 5}}, {{0, 0}}, true), (Domains{{4, 5}}));
}

TEST_F(DomainsOfAFolder, FolderWithoutDocuments_HasNoDomains) {
  const auto folder = participant("p");
  write(folder.governance, "nothing");
  // This is the domain of the grant.
  EXPECT_EQ(domains_of(load_folder(folder, kNow), kNow), (Domains{{0, 0}}));
  write(folder.permissions, "nothing");
  EXPECT_EQ(domains_of(load_folder(folder, kNow), kNow), Domains());
}

DomainChoice choice_of(const std::vector<Domains>& participants) {
  return choose_domain(participants);
}

TEST(ChooseDomain, TheOnlyOne_IsTaken) {
  const auto choice = choice_of({{{7, 7}}});
  EXPECT_EQ(choice.domain, 7);
  EXPECT_FALSE(choice.has_others());
}

TEST(ChooseDomain, SeveralDomains_GiveDomain0OrTheLowest) {
  EXPECT_EQ(choice_of({{{0, 9}}}).domain, 0);
  EXPECT_TRUE(choice_of({{{0, 9}}}).has_others());
  EXPECT_EQ(choice_of({{{3, 3}, {8, 8}}}).domain, 3);
  EXPECT_TRUE(choice_of({{{3, 3}, {8, 8}}}).has_others());
}

TEST(ChooseDomain, TwoParticipants_MeetWhereBothAre) {
  EXPECT_EQ(choice_of({{{0, 5}}, {{5, 9}}}).domain, 5);
  EXPECT_FALSE(choice_of({{{0, 5}}, {{5, 9}}}).has_others());
  EXPECT_EQ(choice_of({{{1, 1}}, {{2, 2}}}).domain, 1);
  EXPECT_EQ(choice_of({{}, {{2, 2}}}).domain, 2);
}

TEST(ChooseDomain, FoldersWithoutDocuments_GiveDomain0) {
  EXPECT_EQ(choice_of({}).domain, 0);
  EXPECT_FALSE(choice_of({{}}).has_others());
}

TEST(DomainWords, ManyRanges_AreNamedUpToABound) {
  EXPECT_EQ(to_text({{0, 5}, {7, 7}}), "0-5, 7");
  Domains many;
  for (DomainId id = 0; id <= 230; id += 2) many.push_back({id, id});
  EXPECT_TRUE(to_text(many).ends_with(", ..."));
  EXPECT_LT(to_text(many).size(), 160u);
}

}  // namespace
}  // namespace ddssec::governance::doctor
