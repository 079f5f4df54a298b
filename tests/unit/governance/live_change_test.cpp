#include "governance/live_change.hpp"

#include <gtest/gtest.h>

#include "tests/support/expect_code.hpp"

namespace ddssec::governance {
namespace {

TopicRule rule_for(std::string expression, ProtectionKind data = ProtectionKind::encrypt) {
  return {.topic_expression = std::move(expression), .data_protection_kind = data};
}
DomainRule domain(std::vector<TopicRule> rules) { return {.topic_rules = std::move(rules)}; }

TEST(AddedTopicRules, SameDocument_AddsNothing) {
  const auto former = domain({rule_for("a"), rule_for("*")});
  const auto added = added_topic_rules(former, former);
  ASSERT_TRUE(added);
  EXPECT_TRUE(added->rules.empty());
}

TEST(AddedTopicRules, RuleAtTheEnd_IsLast) {
  const auto next = domain({rule_for("a"), rule_for("b")});
  const auto added = added_topic_rules(domain({rule_for("a")}), next);
  ASSERT_TRUE(added);
  ASSERT_EQ(added->rules.size(), 1u);
  EXPECT_EQ(added->rules.front(), &next.topic_rules.back());
  EXPECT_TRUE(added->are_last);
}

TEST(AddedTopicRules, RuleBeforeAnother_IsNotLast) {
  const auto added =
      added_topic_rules(domain({rule_for("*")}), domain({rule_for("a"), rule_for("*")}));
  ASSERT_TRUE(added);
  EXPECT_EQ(added->rules.size(), 1u);
  EXPECT_FALSE(added->are_last);
}

TEST(AddedTopicRules, RuleThatLeftOrMovedOrChanged_IsRefused) {
  const auto former = domain({rule_for("a"), rule_for("*")});
  for (const auto& next :
       {domain({rule_for("*")}), domain({rule_for("*"), rule_for("a")}), domain({}),
        domain({rule_for("a", ProtectionKind::none), rule_for("*")})})
    EXPECT_CODE(added_topic_rules(former, next), governance_renewal_refused);
}

TEST(AddedTopicRules, EachElementOfTheDomain_MustStay) {
  const auto former = domain({});
  const auto refuses = [&](std::string_view element, auto&& change) {
    auto next = former;
    next.line = 7;
    change(next);
    const auto added = added_topic_rules(former, next);
    ASSERT_FALSE(added) << element;
    EXPECT_EQ(added.error().details().field, element);
    EXPECT_EQ(added.error().details().line, 7);
    EXPECT_NE(added.error().details().expected, added.error().details().found);
  };
  refuses("allow_unauthenticated_participants",
          [](auto& rule) { rule.allow_unauthenticated_participants = true; });
  refuses("enable_join_access_control",
          [](auto& rule) { rule.enable_join_access_control = false; });
  refuses("enable_key_revision", [](auto& rule) { rule.enable_key_revision = true; });
  refuses("discovery_protection_kind",
          [](auto& rule) { rule.discovery_protection_kind = ProtectionKind::none; });
  refuses("liveliness_protection_kind",
          [](auto& rule) { rule.liveliness_protection_kind = ProtectionKind::sign; });
  refuses("rtps_protection_kind",
          [](auto& rule) { rule.rtps_protection_kind = ProtectionKind::none; });
  refuses("rtps_psk_protection_kind",
          [](auto& rule) { rule.rtps_psk_protection_kind = ProtectionKind::sign; });
  refuses("allowed_crypto_algorithms", [](auto& rule) { rule.allowed_algorithms.emplace(); });
}

TEST(AddedTopicRules, AllowedAlgorithms_MustStay) {
  auto former = domain({});
  former.allowed_algorithms.emplace();
  former.allowed_algorithms->key_establishment = {{"ECDHE-CEUM+P256"}};
  auto next = former;
  EXPECT_TRUE(added_topic_rules(former, next));
  next.allowed_algorithms->key_establishment.push_back({"ECDHE-CEUM+P384"});
  const auto added = added_topic_rules(former, next);
  ASSERT_FALSE(added);
  EXPECT_EQ(added.error().details().field, "key_establishment");
  EXPECT_EQ(added.error().details().found, "ECDHE-CEUM+P256, ECDHE-CEUM+P384");
}

TEST(AddedTopicRules, RuleThatOpensDiscovery_IsRefusedWhereAllIsProtected) {
  auto open = rule_for("open");
  open.enable_discovery_protection = false;
  open.line = 9;
  const auto former = domain({rule_for("a")});
  EXPECT_TRUE(protects_all_discovery(former));
  for (const auto& next : {domain({rule_for("a"), open}), domain({open, rule_for("a")})}) {
    EXPECT_FALSE(protects_all_discovery(next));
    const auto added = added_topic_rules(former, next);
    ASSERT_FALSE(added);
    EXPECT_EQ(added.error().code(), Code::governance_renewal_refused);
    EXPECT_EQ(added.error().details().field, "enable_discovery_protection");
    EXPECT_EQ(added.error().details().found, "false for \"open\"");
    EXPECT_EQ(added.error().details().line, 9);
  }
}

TEST(AddedTopicRules, RuleThatOpensDiscovery_IsTakenWhereSomeIsOpen) {
  auto open = rule_for("open"), further = rule_for("further");
  open.enable_discovery_protection = further.enable_discovery_protection = false;
  EXPECT_TRUE(added_topic_rules(domain({open}), domain({open, further})));
  auto former = domain({rule_for("a")});
  former.discovery_protection_kind = ProtectionKind::none;
  auto next = former;
  next.topic_rules.push_back(open);
  EXPECT_FALSE(protects_all_discovery(former));
  EXPECT_TRUE(added_topic_rules(former, next));
}

TEST(ProtectAlike, LooksAtEveryValue) {
  const auto rule = rule_for("a");
  EXPECT_TRUE(protect_alike(rule, rule_for("b")));
  const auto differs = [&](auto&& change) {
    auto other = rule;
    change(other);
    EXPECT_FALSE(protect_alike(rule, other));
  };
  differs([](auto& one) { one.enable_discovery_protection = false; });
  differs([](auto& one) { one.enable_liveliness_protection = false; });
  differs([](auto& one) { one.enable_read_access_control = false; });
  differs([](auto& one) { one.enable_write_access_control = false; });
  differs([](auto& one) { one.metadata_protection_kind = ProtectionKind::sign; });
  differs([](auto& one) { one.data_protection_kind = ProtectionKind::sign; });
}

}  // namespace
}  // namespace ddssec::governance
