#include "governance/compare/governance_diff.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/governance_compare/documents.hpp"

namespace ddssec::governance {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using enum ChangeClass;

TEST(GovernanceDiff, AFlagWithNothingBehindIt_IsNeutralButBreaks) {
  auto low = plain(), high = plain();
  for (auto* document : {&low, &high}) {
    document->domain_rules[0].discovery_protection_kind = Kind::none;
    document->domain_rules[0].liveliness_protection_kind = Kind::none;
  }
  low.domain_rules[0].topic_rules[0].enable_discovery_protection = false;
  low.domain_rules[0].topic_rules[0].enable_liveliness_protection = false;
  const auto diff = compare(high, low);
  EXPECT_EQ(diff.verdict, neutral);
  ASSERT_THAT(diff.changes, SizeIs(2));
  EXPECT_EQ(diff.changes[0].element.change, neutral);
  EXPECT_EQ(diff.changes[0].element.interop, Interop::endpoint);
  EXPECT_THAT(diff.flag_day_domains, ElementsAre(DomainRange{0, 0}));
}

TEST(GovernanceDiff, AnIncomparableKind_IsMixed) {
  auto before = plain(), after = plain();
  before.domain_rules[0].rtps_protection_kind = Kind::encrypt;
  after.domain_rules[0].rtps_protection_kind = Kind::sign_with_origin_authentication;
  EXPECT_EQ(compare(before, after).verdict, mixed);
}

TEST(GovernanceDiff, RulesInOtherWords_AreNeutral) {
  const auto before = document({topic("rt/x"), topic("rt/y"), topic("*", Kind::sign)});
  const auto after = document({topic("rt/[xy]"), topic("*", Kind::sign)});
  const auto diff = compare(before, after);
  EXPECT_EQ(diff.verdict, neutral);
  EXPECT_THAT(diff.changes, IsEmpty());
  ASSERT_THAT(diff.rewritten, SizeIs(1));
  EXPECT_THAT(diff.rewritten[0].only_old, ElementsAre("rt/x", "rt/y"));
  EXPECT_THAT(diff.rewritten[0].only_new, ElementsAre("rt/[xy]"));
}

TEST(GovernanceDiff, TheOrderOfRules_Counts) {
  const auto before = document({topic("rt/cmd*"), topic("rt/*", Kind::sign)});
  const auto after = document({topic("rt/*", Kind::sign), topic("rt/cmd*")});
  const auto diff = compare(before, after);
  EXPECT_EQ(diff.verdict, weaker);
  ASSERT_THAT(diff.changes, SizeIs(1));
  EXPECT_EQ(diff.changes[0].witness, "rt/cmd");
  EXPECT_THAT(diff.changes[0].expressions_old, ElementsAre("rt/cmd*"));
  EXPECT_THAT(diff.changes[0].expressions_new, ElementsAre("rt/*"));

  const auto swapped = document({topic("rt/a*"), topic("rt/b*", Kind::sign)});
  const auto apart = document({topic("rt/b*", Kind::sign), topic("rt/a*")});
  EXPECT_EQ(compare(swapped, apart).verdict, neutral);
}

// Topics of rt/cmd lose their own secrecy towards insiders, and everything gains a second layer.
TEST(GovernanceDiff, WorkThatMovesToAnotherLayer_IsToldByAttacker) {
  auto before = document({topic("rt/cmd*", Kind::encrypt, 22), topic("*", Kind::sign, 30)});
  auto after = document({topic("rt/cmd*", Kind::sign, 23), topic("*", Kind::sign, 31)});
  for (auto* document : {&before, &after}) {
    for (auto& rule : document->domain_rules[0].topic_rules) {
      rule.metadata_protection_kind = Kind::none;
    }
  }
  after.domain_rules[0].rtps_protection_kind = Kind::encrypt;
  const auto diff = compare(before, after);
  EXPECT_EQ(diff.verdict, mixed);
  ASSERT_THAT(diff.changes, SizeIs(2));
  EXPECT_EQ(diff.changes[0].element.element, "data_protection_kind");
  EXPECT_EQ(diff.changes[0].witness, "rt/cmd");
  EXPECT_EQ(diff.changes[0].old_line(), 22);
  EXPECT_EQ(diff.changes[0].new_line(), 23);
  EXPECT_THAT(listed(diff.changes[0].lost), ElementsAre(ProtectionProperty::insider_payload_secrecy,
                                                        ProtectionProperty::relay_payload_secrecy));
  EXPECT_EQ(diff.changes[1].element.element, "rtps_protection_kind");
  EXPECT_EQ(diff.changes[1].element.change, stronger);
}

// One change does not make up for another, because each layer protects against an attacker of its
// own.
TEST(GovernanceDiff, AnotherLayer_DoesNotMakeUpForPayload) {
  auto before = document({topic("*", Kind::encrypt)});
  auto after = document({topic("*", Kind::none)});
  before.domain_rules[0].topic_rules[0].metadata_protection_kind = Kind::none;
  after.domain_rules[0].topic_rules[0].metadata_protection_kind = Kind::none;
  after.domain_rules[0].rtps_protection_kind = Kind::encrypt;
  const auto diff = compare(before, after);
  EXPECT_EQ(diff.verdict, mixed);
  EXPECT_THAT(listed(diff.changes[0].lost),
              ElementsAre(ProtectionProperty::insider_payload_secrecy,
                          ProtectionProperty::insider_payload_integrity,
                          ProtectionProperty::relay_payload_secrecy,
                          ProtectionProperty::relay_payload_integrity));
}

// Relays hold the keys of submessages only (DDS-Security 1.2, clause 9.5.1.9.3).
TEST(GovernanceDiff, RelayedTopics_AreReadWhereOnlySubmessagesAreProtected) {
  auto before = plain(), after = plain();
  before.domain_rules[0].topic_rules[0].data_protection_kind = Kind::encrypt;
  after.domain_rules[0].topic_rules[0].metadata_protection_kind = Kind::encrypt;
  const auto diff = compare(before, after);
  EXPECT_EQ(diff.verdict, mixed);
  ASSERT_THAT(diff.changes, SizeIs(2));
  EXPECT_EQ(diff.changes[0].element.element, "data_protection_kind");
  EXPECT_THAT(listed(diff.changes[0].lost), ElementsAre(ProtectionProperty::relay_payload_secrecy));
  EXPECT_TRUE(diff.changes[0].gained.none());
  EXPECT_TRUE(diff.changes[1].lost.none()) << "told where it is lost";
}

// The payloads are sent in the clear, beside something that gets stronger.
TEST(GovernanceDiff, StrongerLines_HideNoWeakerOne) {
  const auto before = document({topic("cmd"), topic("other", Kind::sign)});
  auto after = document({topic("cmd", Kind::none), topic("other", Kind::sign)});
  EXPECT_EQ(compare(before, after).verdict, weaker);
  for (const auto& stronger_too : std::vector<std::function<void(DomainRule&)>>{
           [](DomainRule& rule) { rule.enable_key_revision = true; },
           [](DomainRule& rule) { rule.rtps_psk_protection_kind = Kind::sign; },
           [](DomainRule& rule) {
             rule.rtps_protection_kind = Kind::encrypt_with_origin_authentication;
           },
           [](DomainRule& rule) { rule.topic_rules[1].data_protection_kind = Kind::encrypt; }}) {
    auto changed = after;
    stronger_too(changed.domain_rules[0]);
    EXPECT_EQ(compare(before, changed).verdict, mixed);
  }
}

// Each line says what its own element does.
TEST(GovernanceDiff, AStrongerLine_LosesNothing) {
  auto before = document({topic("camera", Kind::none)}),
       after = document({topic("camera", Kind::sign)});
  before.domain_rules[0].topic_rules[0].metadata_protection_kind = Kind::encrypt;
  after.domain_rules[0].topic_rules[0].metadata_protection_kind = Kind::none;
  const auto diff = compare(before, after);
  ASSERT_THAT(diff.changes, SizeIs(2));
  EXPECT_EQ(diff.changes[0].element.element, "metadata_protection_kind");
  EXPECT_TRUE(diff.changes[0].lost.test(
      static_cast<std::size_t>(ProtectionProperty::insider_payload_secrecy)));
  EXPECT_EQ(diff.changes[1].element.change, stronger);
  EXPECT_TRUE(diff.changes[1].lost.none());
  EXPECT_THAT(listed(diff.changes[1].gained),
              ElementsAre(ProtectionProperty::relay_payload_integrity));
}

TEST(GovernanceDiff, AChangeOfADomain_NamesTheTopicsItMattersFor) {
  auto before = document({topic("open", Kind::none), topic("*", Kind::encrypt)});
  for (auto& rule : before.domain_rules[0].topic_rules) rule.metadata_protection_kind = Kind::none;
  before.domain_rules[0].rtps_protection_kind = Kind::encrypt;
  auto after = before;
  after.domain_rules[0].rtps_protection_kind = Kind::none;
  const auto diff = compare(before, after);
  ASSERT_THAT(diff.changes, SizeIs(1));
  EXPECT_TRUE(diff.changes[0].lost.test(
      static_cast<std::size_t>(ProtectionProperty::outsider_payload_secrecy)));
  const auto& of_some = diff.changes[0].of_some;
  const auto found = std::ranges::find(of_some, ProtectionProperty::outsider_payload_secrecy,
                                       &PropertyOfSome::property);
  ASSERT_NE(found, of_some.end());
  EXPECT_EQ(found->witness, "open");
}

TEST(GovernanceDiff, Topics_AreToldByTheNarrowerExpression) {
  const auto before = document({topic("*", Kind::encrypt)});
  const auto after = document({topic("rt/diagnostics*", Kind::none), topic("*", Kind::encrypt)});
  const auto diff = compare(before, after);
  ASSERT_THAT(diff.changes, SizeIs(1));
  EXPECT_THAT(diff.changes[0].topics.words,
              ElementsAre(TopicWords{.expression = "rt/diagnostics*"}));
  const auto rest = document({topic("rt/diagnostics*", Kind::encrypt), topic("*", Kind::none)});
  EXPECT_THAT(compare(before, rest).changes[0].topics.words,
              ElementsAre(TopicWords{.expression = "*", .except = {"rt/diagnostics*"}}));
  const auto crossing = document({topic("*x", Kind::none), topic("*", Kind::encrypt)});
  const auto starting = document({topic("a*", Kind::encrypt), topic("*", Kind::none)});
  EXPECT_THAT(compare(starting, crossing).changes[0].topics.words,
              ElementsAre(TopicWords{.expression = "a*", .also = "*x"}));
}

TEST(GovernanceDiff, Domains_AreCutWhereEitherDocumentCutsThem) {
  auto before = plain(), after = plain();
  before.domain_rules[0].domains.ranges = {{0, 9}};
  after.domain_rules[0].domains.ranges = {{5, 20}};
  after.domain_rules[0].rtps_protection_kind = Kind::encrypt;
  const auto diff = compare(before, after);
  ASSERT_THAT(diff.changes, SizeIs(3));
  EXPECT_EQ(diff.changes[0].element.change, wider);
  EXPECT_THAT(diff.changes[0].scope.domains, ElementsAre(DomainRange{10, 20}));
  EXPECT_EQ(diff.changes[1].element.change, narrower);
  EXPECT_THAT(diff.changes[1].scope.domains, ElementsAre(DomainRange{0, 4}));
  EXPECT_THAT(diff.changes[2].scope.domains, ElementsAre(DomainRange{5, 9}));
  EXPECT_EQ(diff.changes[2].element.change, stronger);
  EXPECT_THAT(diff.flag_day_domains, ElementsAre(DomainRange{0, 20}));
  EXPECT_EQ(diff.verdict, mixed);
}

TEST(GovernanceDiff, TheFirstRuleForADomain_Counts) {
  auto before = plain();
  before.domain_rules.push_back(before.domain_rules[0]);
  auto after = before;
  after.domain_rules[1].rtps_protection_kind = Kind::none;
  EXPECT_EQ(compare(before, after).verdict, neutral) << "it never applied";
  std::swap(after.domain_rules[0], after.domain_rules[1]);
  EXPECT_EQ(compare(before, after).verdict, weaker);
}

TEST(GovernanceDiff, DomainTags_AreToldApart) {
  auto before = plain();
  before.domain_rules[0].domains.tags = {{"floor*"}};
  auto after = before;
  after.domain_rules[0].domains.tags = {{"floor*"}, {"roof"}};
  auto diff = compare(before, after);
  EXPECT_EQ(diff.verdict, weaker);
  ASSERT_THAT(diff.changes, SizeIs(1));
  EXPECT_EQ(diff.changes[0].element.change, wider);
  EXPECT_THAT(diff.changes[0].scope.tags.examples, ElementsAre("roof"));

  after.domain_rules[0].domains.tags.clear();
  after.domain_rules[0].domains.tag_expressions = {{"floor*"}};
  diff = compare(before, after);
  ASSERT_THAT(diff.changes, SizeIs(1));
  EXPECT_THAT(diff.changes[0].scope.tags.examples, ElementsAre("floor"))
      << "a tag is literal, an expression not";
  EXPECT_EQ(diff.changes[0].scope.tags.form, NameSet::Form::some) << "all but the literal one";

  for (int i = 0; i < 100; ++i) {
    after.domain_rules[0].domains.tags.push_back({std::to_string(i)});
  }
  EXPECT_EQ(compare(before, after).verdict, unknown);
}

// Only the combinations of domain and tag that change are reported.
TEST(GovernanceDiff, DomainsAndTags_AreToldTogether) {
  auto before = plain(), after = plain();
  before.domain_rules[0].domains.ranges = {{2, 2}};
  after.domain_rules[0].domains = {.ranges = {{2, 3}}, .tag_expressions = {{"*"}}};
  const auto diff = compare(before, after);
  ASSERT_THAT(diff.changes, SizeIs(2));
  const auto& [at_two, at_three] = std::tie(diff.changes[0], diff.changes[1]);
  EXPECT_THAT(at_two.scope.domains, ElementsAre(DomainRange{2, 2}));
  EXPECT_EQ(at_two.scope.tags.form, NameSet::Form::every_but);
  EXPECT_THAT(at_two.scope.tags.expressions, ElementsAre(""));
  EXPECT_THAT(at_three.scope.domains, ElementsAre(DomainRange{3, 3}));
  EXPECT_EQ(at_three.scope.tags.form, NameSet::Form::every);
}

// DDS-Security 1.2, clause 10.4.1.2.5.9.
TEST(GovernanceDiff, AnAbsentListOfAlgorithms_IsNotStrongerOrWeaker) {
  auto before = plain(), after = plain();
  AllowedAlgorithms lists;
  lists.digital_signature = {{"ECDSA+P256+SHA256"}};
  lists.key_establishment = {{"ECDHE-CEUM+P256"}};
  lists.symmetric_cipher = {{"AES256+GCM"}};
  before.domain_rules[0].allowed_algorithms = lists;
  lists.digital_signature_identity_trust_chain = lists.digital_signature;
  after.domain_rules[0].allowed_algorithms = lists;
  EXPECT_THAT(compare(before, after).changes, IsEmpty()) << "absent means as for signatures";

  lists.digital_signature_identity_trust_chain.push_back({"ECDSA+P384+SHA384"});
  after.domain_rules[0].allowed_algorithms = lists;
  EXPECT_EQ(compare(before, after).verdict, weaker);

  AllowedAlgorithms all;
  all.digital_signature = {{"RSASSA-PSS-MGF1SHA256+2048+SHA256"},
                           {"RSASSA-PKCS1-V1_5+2048+SHA256"},
                           {"ECDSA+P256+SHA256"},
                           {"ECDSA+P384+SHA384"}};
  all.key_establishment = {{"DHE+MODP-2048-256"}, {"ECDHE-CEUM+P256"}, {"ECDHE-CEUM+P384"}};
  all.symmetric_cipher = {{"AES128+GCM"}, {"AES256+GCM"}};
  after.domain_rules[0].allowed_algorithms = all;
  EXPECT_THAT(compare(plain(), after).changes, IsEmpty()) << "every algorithm is no restriction";
}

TEST(GovernanceDiff, AllowedAlgorithms_AreSets) {
  auto before = plain(), after = plain();
  AllowedAlgorithms lists;
  lists.symmetric_cipher = {{"AES256+GCM"}};
  after.domain_rules[0].allowed_algorithms = lists;
  EXPECT_EQ(compare(before, after).verdict, stronger);
  EXPECT_EQ(compare(after, before).verdict, weaker);
  EXPECT_THAT(compare(before, after).flag_day_domains, IsEmpty());

  before = after;
  before.domain_rules[0].allowed_algorithms->symmetric_cipher = {{"CHACHA20+POLY1305"}};
  const auto diff = compare(before, after);
  EXPECT_EQ(diff.verdict, mixed);
  EXPECT_EQ(diff.changes[0].element.element, "allowed_crypto_algorithms/symmetric_cipher");
  EXPECT_THAT(diff.flag_day_domains, SizeIs(1)) << "they have no cipher in common";
}

TEST(GovernanceDiff, OnlyTopicsInUse_CanBeAskedFor) {
  const auto before = document({topic("rt/cmd*"), topic("rt/*", Kind::sign)});
  const auto after = document({topic("rt/cmd"), topic("rt/*", Kind::sign)});
  EXPECT_EQ(compare(before, after).verdict, weaker);
  EXPECT_EQ(compare(before, after).changes[0].witness, "rt/cmda");
  EXPECT_EQ(compare(before, after, {.topics = {"rt/cmd", "rt/scan", "other"}}).verdict, neutral);
  EXPECT_EQ(compare(before, after, {.topics = {"rt/cmd2"}}).verdict, weaker);
}

TEST(GovernanceDiff, QuestionTooHard_IsUnknown) {
  const auto before = document({topic("*a" + std::string(12, '?')), topic("*", Kind::none)});
  const auto after = document({topic("*[ab]" + std::string(12, '?')), topic("*", Kind::none)});
  const auto diff = compare(before, after);
  EXPECT_EQ(diff.verdict, unknown);
  EXPECT_THAT(diff.unknown_domains, ElementsAre(DomainRange{0, 0}));
  // If the caller names the topics, nothing has to be searched.
  EXPECT_EQ(compare(before, after, {.topics = {"b" + std::string(12, 'x')}}).verdict, stronger);
}

// Far more combinations of a thousand parts of names are possible than can be tried.
std::vector<TopicRule> thousand_rules(Kind kind_of_odd) {
  std::vector<TopicRule> rules;
  for (int i = 0; i < 1000; ++i) {
    rules.push_back(
        topic("*/robot" + std::to_string(i) + "/*", i % 2 ? kind_of_odd : Kind::encrypt));
  }
  return rules;
}

TEST(GovernanceDiff, RulesOfEqualEffect_AreTakenTogetherWhereThereAreTooMany) {
  auto rules = thousand_rules(Kind::encrypt);
  rules.push_back(topic("*", Kind::sign));
  const auto before = document(rules);
  std::swap(rules[0], rules[1]);
  rules.back() = topic("*", Kind::none);
  const auto diff = compare(before, document(rules));
  EXPECT_EQ(diff.verdict, weaker);
  EXPECT_FALSE(diff.complete);
  EXPECT_THAT(diff.unknown_domains, IsEmpty());
  ASSERT_THAT(diff.changes, SizeIs(1));
  EXPECT_EQ(diff.changes[0].witness, "a");
}

TEST(GovernanceDiff, RulesThatOnlyChangeTheirValues_AreProvedOneByOne) {
  auto rules = thousand_rules(Kind::sign);
  rules.push_back(topic("*/robot7/x"));  // is dead
  rules.push_back(topic("*", Kind::sign));
  const auto before = document(rules);
  rules[500].data_protection_kind = Kind::none;
  rules[1000].data_protection_kind = Kind::none;
  auto diff = compare(before, document(rules));
  EXPECT_EQ(diff.verdict, weaker);
  EXPECT_TRUE(diff.complete);
  ASSERT_THAT(diff.changes, SizeIs(1)) << "nobody sees the rule that is dead";
  EXPECT_THAT(diff.changes[0].expressions_old, ElementsAre("*/robot500/*"));
  EXPECT_EQ(diff.changes[0].witness, "/robot500/");

  // The last rule was dead, because another rule has a longer reach.
  rules = thousand_rules(Kind::sign);
  rules.push_back(topic("?*"));
  rules.push_back(topic("*"));
  const auto open = document(rules);
  rules.back().data_protection_kind = Kind::none;
  diff = compare(open, document(rules));
  ASSERT_THAT(diff.changes, SizeIs(1));
  EXPECT_EQ(diff.changes[0].witness, "") << "the empty name is all that is left";
}

TEST(GovernanceDiff, WhatIsFoundBeforeALimit_IsShown) {
  auto rules = thousand_rules(Kind::sign);
  const auto before = document(rules);
  rules[500].data_protection_kind = Kind::sign;
  rules.push_back(topic("*/robot0/*"));  // dead, but the lists are no longer alike
  auto diff = compare(before, document(rules));
  EXPECT_EQ(diff.verdict, unknown) << "it is weaker somewhere, but perhaps also stronger";
  ASSERT_THAT(diff.changes, SizeIs(1));
  EXPECT_THAT(diff.changes[0].expressions_old, ElementsAre("*/robot500/*"));
  rules[501].data_protection_kind = Kind::encrypt;
  diff = compare(before, document(rules));
  EXPECT_EQ(diff.verdict, mixed) << "whatever else there may be";
  EXPECT_THAT(diff.unknown_domains, SizeIs(1));
}

}  // namespace
}  // namespace ddssec::governance
