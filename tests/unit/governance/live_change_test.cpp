#include "governance/live_change.hpp"

#include <array>
#include <set>

#include <gtest/gtest.h>

#include "tests/support/expect_code.hpp"

namespace ddssec::governance {
namespace {

TopicRule rule_for(std::string expression, ProtectionKind data = ProtectionKind::encrypt) {
  return {.topic_expression = std::move(expression), .data_protection_kind = data};
}
DomainRule domain(std::vector<TopicRule> rules) { return {.topic_rules = std::move(rules)}; }

TEST(LiveChange, SameDocument_AddsNothing) {
  const auto former = domain({rule_for("a"), rule_for("*")});
  const auto added = live_change(former, former);
  ASSERT_TRUE(added);
  EXPECT_TRUE(added->is_empty());
}

TEST(LiveChange, RuleAtTheEnd_IsLast) {
  const auto next = domain({rule_for("a"), rule_for("b")});
  const auto added = live_change(domain({rule_for("a")}), next);
  ASSERT_TRUE(added);
  ASSERT_EQ(added->rules.size(), 1u);
  EXPECT_EQ(added->rules.front(), &next.topic_rules.back());
  EXPECT_TRUE(added->are_last);
}

TEST(LiveChange, RuleBeforeAnother_IsNotLast) {
  const auto added = live_change(domain({rule_for("*")}), domain({rule_for("a"), rule_for("*")}));
  ASSERT_TRUE(added);
  EXPECT_EQ(added->rules.size(), 1u);
  EXPECT_FALSE(added->are_last);
  EXPECT_TRUE(added->fit_in_use);
  EXPECT_TRUE(added->are_alike);
}

TEST(LiveChange, RuleThatLeftOrMovedOrChanged_IsRefused) {
  const auto former = domain({rule_for("a"), rule_for("*")});
  for (const auto& next :
       {domain({rule_for("*")}), domain({rule_for("*"), rule_for("a")}), domain({}),
        domain({rule_for("a", ProtectionKind::none), rule_for("*")})})
    EXPECT_CODE(live_change(former, next), governance_renewal_refused);
}

TEST(LiveChange, EachElementOfTheDomain_MustStay) {
  const auto former = domain({});
  const auto refuses = [&](std::string_view element, auto&& change) {
    auto next = former;
    next.line = 7;
    change(next);
    const auto added = live_change(former, next);
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

TEST(LiveChange, AllowedAlgorithms_MustStay) {
  auto former = domain({});
  former.allowed_algorithms.emplace();
  former.allowed_algorithms->key_establishment = {{"ECDHE-CEUM+P256"}};
  auto next = former;
  EXPECT_TRUE(live_change(former, next));
  next.allowed_algorithms->key_establishment.push_back({"ECDHE-CEUM+P384"});
  const auto added = live_change(former, next);
  ASSERT_FALSE(added);
  EXPECT_EQ(added.error().details().field, "key_establishment");
  EXPECT_EQ(added.error().details().found, "ECDHE-CEUM+P256, ECDHE-CEUM+P384");
}

TEST(LiveChange, RuleThatOpensDiscovery_IsRefusedWhereAllIsProtected) {
  auto open = rule_for("open");
  open.enable_discovery_protection = false;
  open.line = 9;
  const auto former = domain({rule_for("a")});
  EXPECT_TRUE(protects_all_discovery(former));
  for (const auto& next : {domain({rule_for("a"), open}), domain({open, rule_for("a")})}) {
    EXPECT_FALSE(protects_all_discovery(next));
    const auto added = live_change(former, next);
    ASSERT_FALSE(added);
    EXPECT_EQ(added.error().code(), Code::governance_renewal_refused);
    EXPECT_EQ(added.error().details().field, "enable_discovery_protection");
    EXPECT_EQ(added.error().details().found, "false for \"open\"");
    EXPECT_EQ(added.error().details().line, 9);
  }
}

TEST(LiveChange, RuleThatOpensDiscovery_IsTakenWhereSomeIsOpen) {
  auto open = rule_for("open"), further = rule_for("further");
  open.enable_discovery_protection = further.enable_discovery_protection = false;
  EXPECT_TRUE(live_change(domain({open}), domain({open, further})));
  auto former = domain({rule_for("a")});
  former.discovery_protection_kind = ProtectionKind::none;
  auto next = former;
  next.topic_rules.push_back(open);
  EXPECT_FALSE(protects_all_discovery(former));
  EXPECT_TRUE(live_change(former, next));
}

// ---- rules that protect more

TopicRule kinds(ProtectionKind metadata, ProtectionKind data) {
  return {
      .topic_expression = "a", .metadata_protection_kind = metadata, .data_protection_kind = data};
}
DomainRule of(TopicRule rule, ProtectionKind rtps = ProtectionKind::none) {
  return {.rtps_protection_kind = rtps, .topic_rules = {std::move(rule)}};
}
constexpr auto kNone = ProtectionKind::none, kSign = ProtectionKind::sign,
               kEncrypt = ProtectionKind::encrypt,
               kSignOrigin = ProtectionKind::sign_with_origin_authentication,
               kEncryptOrigin = ProtectionKind::encrypt_with_origin_authentication;

TEST(LiveChange, MoreProtection_IsRaised) {
  struct Row {
    ProtectionKind metadata_before, data_before, metadata, data;
  };
  for (const auto& row :
       {Row{kSign, kSign, kEncrypt, kEncrypt}, Row{kNone, kNone, kSign, kSign},
        Row{kNone, kNone, kEncrypt, kEncrypt}, Row{kSign, kNone, kEncrypt, kNone},
        Row{kNone, kSign, kSign, kSign}, Row{kSignOrigin, kSign, kEncryptOrigin, kEncrypt},
        Row{kNone, kSign, kEncrypt, kEncrypt}}) {
    const auto next = of(kinds(row.metadata, row.data));
    const auto change = live_change(of(kinds(row.metadata_before, row.data_before)), next);
    ASSERT_TRUE(change) << change.error().to_sentence();
    EXPECT_TRUE(change->rules.empty());
    ASSERT_EQ(change->raised.size(), 1u);
    EXPECT_EQ(change->raised.front(), &next.topic_rules.front());
  }
}

TEST(LiveChange, LessProtection_OrWhatReceiversCannotTellApart_IsRefused) {
  struct Row {
    ProtectionKind metadata_before, data_before, metadata, data;
    std::string_view field;
  };
  constexpr std::string_view kMetadata = "metadata_protection_kind", kData = "data_protection_kind";
  for (const auto& row :
       {Row{kEncrypt, kEncrypt, kSign, kEncrypt, kMetadata},
        Row{kEncrypt, kEncrypt, kEncrypt, kSign, kData}, Row{kSign, kSign, kNone, kSign, kMetadata},
        Row{kSign, kSign, kEncrypt, kNone, kData}, Row{kSign, kSign, kSignOrigin, kSign, kMetadata},
        Row{kEncryptOrigin, kSign, kEncrypt, kSign, kMetadata},
        Row{kNone, kNone, kNone, kEncrypt, kMetadata}, Row{kNone, kNone, kNone, kSign, kMetadata},
        Row{kSign, kSign, kSign, kEncrypt, kMetadata}}) {
    const auto change = live_change(of(kinds(row.metadata_before, row.data_before)),
                                    of(kinds(row.metadata, row.data)));
    EXPECT_CODE(change, governance_renewal_refused);
    EXPECT_EQ(change.error().details().field, row.field);
  }
}

TEST(LiveChange, EncryptedMessages_HideKeyHashesToo) {
  EXPECT_TRUE(live_change(of(kinds(kSign, kSign), kEncrypt), of(kinds(kSign, kEncrypt), kEncrypt)));
  EXPECT_TRUE(live_change(of(kinds(kNone, kSign), kEncrypt), of(kinds(kNone, kEncrypt), kEncrypt)));
}

TEST(LiveChange, FlagsOfATopic_MayOnlyBeginToCount) {
  for (const auto& [element, flag] :
       {std::pair("enable_discovery_protection", &TopicRule::enable_discovery_protection),
        std::pair("enable_liveliness_protection", &TopicRule::enable_liveliness_protection),
        std::pair("enable_read_access_control", &TopicRule::enable_read_access_control),
        std::pair("enable_write_access_control", &TopicRule::enable_write_access_control)}) {
    const auto more = kinds(kSign, kSign);
    auto less = more;
    less.*flag = false;
    const auto raised = live_change(of(less), of(more));
    ASSERT_TRUE(raised) << element;
    EXPECT_EQ(raised->raised.size(), 1u) << element;
    const auto lowered = live_change(of(more), of(less));
    EXPECT_CODE(lowered, governance_renewal_refused);
    EXPECT_EQ(lowered.error().details().field, element);
    EXPECT_CODE(check_topic_change(more, of(less), less), governance_renewal_refused);
  }
}

// The topics that the added rule takes from the later rule may be in use.
TEST(LiveChange, FlagThatIsMissingInAnAddedRule_DoesNotFitInUse) {
  for (const auto flag :
       {&TopicRule::enable_discovery_protection, &TopicRule::enable_liveliness_protection,
        &TopicRule::enable_read_access_control, &TopicRule::enable_write_access_control}) {
    auto added = rule_for("a"), later = rule_for("*");
    EXPECT_TRUE(live_change(domain({later}), domain({added, later}))->fit_in_use);
    added.*flag = false;
    auto other = later;
    other.topic_expression = "z";
    other.enable_discovery_protection = false;  // so that a rule without it may be added
    EXPECT_FALSE(live_change(domain({later, other}), domain({added, later, other}))->fit_in_use);
  }
}

// ---- kinds of the domain

struct KindOfTheDomain {
  std::string_view element;
  ProtectionKind DomainRule::*kind;
};
constexpr std::array kKindsOfTheDomain = {
    KindOfTheDomain{"discovery_protection_kind", &DomainRule::discovery_protection_kind},
    KindOfTheDomain{"liveliness_protection_kind", &DomainRule::liveliness_protection_kind},
    KindOfTheDomain{"rtps_protection_kind", &DomainRule::rtps_protection_kind}};
constexpr std::array kAllKinds = {kNone, kSign, kEncrypt, kSignOrigin, kEncryptOrigin};

TEST(LiveChange, KindsOfTheDomain_MayOnlyRise) {
  const std::set<std::pair<ProtectionKind, ProtectionKind>> rise = {
      {kNone, kSign}, {kNone, kEncrypt}, {kSign, kEncrypt}, {kSignOrigin, kEncryptOrigin}};
  for (const auto& [element, kind] : kKindsOfTheDomain)
    for (const auto before : kAllKinds)
      for (const auto after : kAllKinds) {
        if (before == after) continue;
        auto former = domain({rule_for("a")}), next = former;
        former.*kind = before;
        next.*kind = after;
        next.line = 5;
        const auto change = live_change(former, next);
        ASSERT_EQ(change.has_value(), rise.contains({before, after}))
            << element << to_string(before) << to_string(after);
        if (!change) {
          EXPECT_EQ(change.error().details().field, element);
          EXPECT_EQ(change.error().details().expected, to_string(before));
          EXPECT_EQ(change.error().details().found, to_string(after));
          EXPECT_EQ(change.error().details().line, 5);
          continue;
        }
        EXPECT_FALSE(change->is_empty());
        ASSERT_EQ(change->domain.size(), 1u);
        EXPECT_EQ(change->domain.front().element, element);
        EXPECT_EQ(change->domain.front().former, to_string(before));
        EXPECT_EQ(change->domain.front().next, to_string(after));
        EXPECT_EQ(change->domain.front().line, 5);
      }
}

// Receivers take messages by either document for a while. If one layer fell while another one
// rose, a message could lack both.
TEST(LiveChange, LayersThatChangePlaces_AreRefused) {
  const auto refused_field = [](const DomainRule& former, const DomainRule& next) {
    const auto change = live_change(former, next);
    return change ? std::string("none") : change.error().details().field;
  };
  EXPECT_EQ(refused_field(of(kinds(kNone, kNone), kSign), of(kinds(kSign, kNone), kNone)),
            "rtps_protection_kind");
  EXPECT_EQ(refused_field(of(kinds(kSign, kNone), kNone), of(kinds(kNone, kNone), kSign)),
            "metadata_protection_kind");
  for (const auto& [element, kind] : kKindsOfTheDomain) {
    auto former = of(kinds(kNone, kNone), kSign), next = of(kinds(kNone, kNone), kNone);
    if (kind == &DomainRule::rtps_protection_kind) continue;
    former.*kind = kNone;
    next.*kind = kSign;
    EXPECT_EQ(refused_field(former, next), "rtps_protection_kind") << element;
    EXPECT_EQ(refused_field(next, former), element);
  }
}

TEST(LiveChange, ProtectionOfMessages_DoesNotBeginWhereUnauthenticatedParticipantsAreAllowed) {
  auto open = of(kinds(kNone, kNone), kNone), closed = of(kinds(kNone, kNone), kSign);
  EXPECT_TRUE(live_change(open, closed));
  open.allow_unauthenticated_participants = closed.allow_unauthenticated_participants = true;
  EXPECT_CODE(live_change(open, closed), governance_renewal_refused);
  auto encrypted = closed;
  encrypted.rtps_protection_kind = kEncrypt;
  EXPECT_TRUE(live_change(closed, encrypted));
}

// ---- rules that were added and rules that protect more

TEST(LiveChange, RaisedBesideAdded_AreToldApart) {
  const auto former = domain({kinds(kSign, kSign), rule_for("*")});
  const auto change = live_change(
      former, domain({rule_for("b"), kinds(kEncrypt, kSign), rule_for("*"), rule_for("c")}));
  ASSERT_TRUE(change) << change.error().to_sentence();
  EXPECT_EQ(change->rules.size(), 2u);
  EXPECT_EQ(change->raised.size(), 1u);
  EXPECT_FALSE(change->are_last);
}

TEST(ProtectAlike, EachValueThatDiffers_Counts) {
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
