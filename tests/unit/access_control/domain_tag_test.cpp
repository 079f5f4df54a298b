// Domain tags select the governance rule and the permission rules (DDS-Security 1.2,
// clause 10.4.1.2.5.1): a rule that lists no tag is for the empty tag only.
#include "tests/support/expect_code.hpp"
#include "tests/unit/access_control/access_control_fixture.hpp"

namespace ddssec::access_control {
namespace {

using governance::DomainSet;

DomainSet tagged(const char* tag) { return {.ranges = {{0, 0}}, .tags = {{tag, 0}}}; }
DomainSet matching(const char* tags) {
  return {.ranges = {{0, 0}}, .tag_expressions = {{tags, 0}}};
}
const DomainSet kUntagged = {.ranges = {{0, 0}}};

class DomainTags : public AccessControlTest {
 protected:
  static governance::DomainRule domain_rule(DomainSet domains, ProtectionKind kind) {
    governance::DomainRule out;
    out.domains = std::move(domains);
    out.rtps_protection_kind = out.discovery_protection_kind = kind;
    out.topic_rules.push_back({.topic_expression = "*"});
    return out;
  }
  static governance::GrantRule rule_for(bool allow, DomainSet domains,
                                        std::vector<std::string> names) {
    auto out = publish_rule(allow, std::move(names));
    out.domains = std::move(domains);
    return out;
  }
  std::string may_do_all_with(const char* subject, DomainSet domains) const {
    return signed_permissions({grant(subject, {rule_for(true, std::move(domains), {"*"})})});
  }
  Result<spi::PermissionsHandle> local_with(std::string_view tag,
                                            std::vector<governance::DomainRule> rules,
                                            const std::string& permissions_file) {
    const governance::Governance content{.domain_rules = std::move(rules)};
    return plugin->validate_local_permissions(
        kLocalIdentity, 0,
        properties(signed_document(governance::to_xml(content)), permissions_file), tag);
  }
  bool may_publish(spi::PermissionsHandle handle, const char* topic) {
    const bool may = plugin->check_create_datawriter(handle, 0, {.topic_name = topic}).has_value();
    log.all.clear();
    return may;
  }
};

constexpr auto kNone = ProtectionKind::none, kEncrypt = ProtectionKind::encrypt;

TEST_F(DomainTags, Tag_SelectsTheGovernanceRule) {
  const std::vector rules = {domain_rule(tagged("secure"), kEncrypt),
                             domain_rule(kUntagged, kNone)};
  const auto permissions = may_do_all_with(kTalker, matching("*"));
  for (const auto& [tag, kind] : {std::pair("secure", kEncrypt), std::pair("", kNone)}) {
    const auto own = local_with(tag, rules, permissions);
    ASSERT_TRUE(own) << own.error().to_sentence();
    const auto attributes = plugin->participant_sec_attributes(*own);
    EXPECT_EQ(attributes->rtps, kind) << tag;
    EXPECT_EQ(attributes->discovery, kind) << tag;
  }
  EXPECT_REFUSED(local_with("other", rules, permissions), domain_not_covered);
}

TEST_F(DomainTags, ARuleWithoutTags_IsForTheEmptyTagAlone) {
  const auto permissions = may_do_all_with(kTalker, matching("*"));
  const auto refused = local_with("secure", {domain_rule(kUntagged, kNone)}, permissions);
  EXPECT_CODE(refused, domain_not_covered);
  EXPECT_NE(refused.error().details().note.find(
                "is in domain 0 with the tag \"secure\", the document covers"),
            std::string::npos)
      << refused.error().details().note;
  EXPECT_CODE(local_with("", {domain_rule(tagged("secure"), kNone)}, permissions),
              domain_not_covered);
  EXPECT_TRUE(local_with("secure", {domain_rule(matching("s*"), kNone)}, permissions));
}

TEST_F(DomainTags, Tag_SelectsThePermissionRules) {
  const std::vector rules = {domain_rule(matching("*"), kNone)};
  const auto permissions = signed_permissions({grant(
      kTalker, {rule_for(false, tagged("secure"), {"a"}), rule_for(true, matching("*"), {"a", "b"}),
                rule_for(true, kUntagged, {"c"})})});
  const auto secure = local_with("secure", rules, permissions),
             empty = local_with("", rules, permissions);
  ASSERT_TRUE(secure && empty);
  EXPECT_FALSE(may_publish(*secure, "a"));  // because the deny rule has the tag
  EXPECT_TRUE(may_publish(*secure, "b"));
  EXPECT_FALSE(may_publish(*secure, "c"));
  EXPECT_TRUE(may_publish(*empty, "a"));
  EXPECT_TRUE(may_publish(*empty, "c"));
}

TEST_F(DomainTags, AParticipantWithoutARuleForItsTag_DoesNotJoin) {
  const auto own = local_with("secure", {domain_rule(matching("*"), kNone)},
                              may_do_all_with(kTalker, kUntagged));
  ASSERT_TRUE(own);
  const auto joined = plugin->check_create_participant(*own, 0);
  EXPECT_CODE(joined, participant_not_allowed);
  EXPECT_EQ(joined.error().details().expected,
            "an allow_rule as the first rule for domain 0 with the tag \"secure\"");
}

TEST_F(DomainTags, Peers_AreJudgedWithTheTagOfTheLocalParticipant) {
  ASSERT_TRUE(local_with("secure", {domain_rule(matching("*"), kNone)},
                         may_do_all_with(kTalker, matching("*"))));
  const auto peer = remote(signed_permissions({grant(
      kListener, {rule_for(true, tagged("secure"), {"a"}), rule_for(true, kUntagged, {"b"})})}));
  ASSERT_TRUE(peer);
  EXPECT_TRUE(plugin->check_remote_participant(*peer, 0));
  EXPECT_TRUE(plugin->check_remote_datawriter(*peer, 0, {.topic_name = "a"}));
  EXPECT_REFUSED(plugin->check_remote_datawriter(*peer, 0, {.topic_name = "b"}),
                 announced_writer_not_allowed);
}

}  // namespace
}  // namespace ddssec::access_control
