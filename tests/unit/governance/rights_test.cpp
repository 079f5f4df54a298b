#include "governance/rights.hpp"

#include "governance/decision.hpp"
#include "governance/grant.hpp"
#include "governance/write.hpp"
#include "tests/unit/governance/schema.hpp"

namespace ddssec::governance {
namespace {

class RightsTest : public ::testing::Test {
 protected:
  // Returns a grant of these rights, written, read back and compiled for domain 3.
  CompiledGrant compiled(const Rights& rights) {
    const auto leaf = make_leaf(pki::make_ca()).certificate;
    const auto xml = to_xml(Permissions{
        .grants = {grant_of("a", leaf, rights, {leaf.not_before(), leaf.not_after()})}});
    EXPECT_TRUE(is_valid(xml, "permissions.xsd"));
    document_ = std::make_shared<Permissions>(permissions_from(xml).value());
    const auto grant = find_grant(*document_, pki::SubjectName::of(leaf), "", pki::kNow);
    EXPECT_TRUE(grant);
    return {document_, **grant, 3};
  }
  static bool may(const CompiledGrant& grant, Action action, std::string_view topic,
                  std::vector<std::string_view> partitions = {}) {
    return grant.judge(action, {.topic = topic, .partitions = partitions}).allowed;
  }

 private:
  std::shared_ptr<Permissions> document_;
};

TEST_F(RightsTest, ListedTopics_AreAllowedAndNothingElse) {
  const auto grant = compiled({.domains = {{0, 5}}, .publish = {"a*"}, .subscribe = {"b", "c"}});
  EXPECT_TRUE(may(grant, Action::publish, "abc"));
  EXPECT_TRUE(may(grant, Action::subscribe, "c"));
  EXPECT_FALSE(may(grant, Action::subscribe, "abc"));
  EXPECT_FALSE(may(grant, Action::publish, "abc", {"red"}));
}

TEST_F(RightsTest, Denials_WinInEveryPartition) {
  const auto grant = compiled({.domains = {{3, 3}},
                               .publish = {"*"},
                               .deny_publish = {"secret*"},
                               .deny_subscribe = {"x"},
                               .partitions = {"red", "blue"}});
  EXPECT_TRUE(may(grant, Action::publish, "open", {"red", "blue"}));
  EXPECT_FALSE(may(grant, Action::publish, "open"));
  EXPECT_FALSE(may(grant, Action::publish, "secret", {"red"}));
  EXPECT_TRUE(grant.judge_participant().allowed) << "a denial must not be the first rule";
}

TEST_F(RightsTest, ParticipantWithoutTopics_MayJoin) {
  const auto grant = compiled({.domains = {{3, 3}}});
  EXPECT_TRUE(grant.judge_participant().allowed);
  EXPECT_FALSE(may(grant, Action::publish, "a"));
}

TEST_F(RightsTest, OtherDomains_AreNotAllowed) {
  EXPECT_FALSE(compiled({.domains = {{4, 4}}, .publish = {"*"}}).judge_participant().allowed);
}

}  // namespace
}  // namespace ddssec::governance
