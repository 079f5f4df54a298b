#include <fmt/format.h>

#include "tests/unit/governance/governance_lint.hpp"

namespace ddssec::governance {
namespace {

using namespace testing_lint;
using enum ProtectionKind;

// Returns the only finding of the whole document.
Finding only(const Governance& document, const GovernanceUse& use = {}) {
  const auto found = lint(document, use);
  EXPECT_EQ(found.size(), 1u);
  for (const auto& finding : found) {
    EXPECT_FALSE(finding.message.empty());
    EXPECT_TRUE(finding.path.starts_with("/dds/domain_access_rules")) << finding.path;
  }
  return found.empty() ? Finding{ddssec::Rule::end_, ""} : found.front();
}

TEST(LintGovernance, StrictProfile_HasNothing) {
  EXPECT_TRUE(lint(changed_strict([](auto&) {})).empty());
  EXPECT_TRUE(lint(governance_of(Profile::strict, {{0, 5}, {7, 9}}), {.domain = 8}).empty());
}

TEST(LintGovernance, OtherProfiles_AreNoticedForWhatTheyLeaveOpen) {
  EXPECT_EQ(only(governance_of(Profile::open, {{0, 0}})).rule, ddssec::Rule::GOV040);
  EXPECT_EQ(only(governance_of(Profile::balanced, {{0, 0}})).rule, ddssec::Rule::GOV031);
}

TEST(LintGovernance, DomainsCoveredTwice_AreFound) {
  auto document = governance_of(Profile::strict, {{0, 5}});
  document.domain_rules.push_back(document.domain_rules[0]);
  document.domain_rules[1].domains.ranges = {{2, 3}, {5, 5}};
  auto found = only(document);
  EXPECT_EQ(found.rule, ddssec::Rule::GOV002);
  EXPECT_EQ(found.message,
            "domain_rule 2 can never apply: domain 2-3, 5 is covered by domain_rule 1 already");
  document.domain_rules[1].domains.ranges = {{5, 7}};
  EXPECT_EQ(only(document).message,
            "domain_rule 2 does not apply to domain 5: domain_rule 1 covers it already");
  document.domain_rules[1].domains.ranges = {{6, 7}};
  EXPECT_TRUE(lint(document).empty());
  // Rules for other tags are for other participants.
  document.domain_rules[1].domains = {.ranges = {{5, 5}}, .tags = {{"red", 0}}};
  EXPECT_TRUE(of(ddssec::Rule::GOV002, document).empty());
}

TEST(LintGovernance, TheDomainOfUse_MustBeCovered) {
  const auto document = governance_of(Profile::strict, {{0, 5}});
  const auto found = only(document, {.domain = 6});
  EXPECT_EQ(found.rule, ddssec::Rule::GOV003);
  EXPECT_EQ(found.severity, Severity::error);
  EXPECT_EQ(found.message, "no domain_rule covers domain 6");
}

TEST(LintGovernance, DeadRules_NameWhatIsInTheirWay) {
  auto weak = strict("rt/a");
  weak.data_protection_kind = none;
  const auto found = only(with_rules({strict("rt/*"), weak, strict("*")}));
  EXPECT_EQ(found.rule, ddssec::Rule::GOV010);
  EXPECT_EQ(found.severity, Severity::error);
  EXPECT_EQ(found.message,
            "topic_rule 2 \"rt/a\" can never apply: \"rt/*\" (rule 1) already matches every name "
            "it matches");
  EXPECT_EQ(found.line, 23);
  EXPECT_EQ(found.path, "/dds/domain_access_rules/domain_rule[1]/topic_access_rules/topic_rule[2]");
}

TEST(LintGovernance, SeveralRules_CanBeInTheWayTogether) {
  auto weak = strict("[ab]");
  weak.data_protection_kind = sign;
  EXPECT_EQ(only(with_rules({strict("a"), strict("b"), weak, strict("*")})).message,
            "topic_rule 3 \"[ab]\" can never apply: \"a\" (rule 1), \"b\" (rule 2) already "
            "together match every name it matches");
}

TEST(LintGovernance, AnExpressionThatMatchesNoName_IsAnError) {
  const auto found = of(ddssec::Rule::GOV010, with_rules({strict("rt/[z-a]"), strict("*")}));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].severity, Severity::error);
  EXPECT_EQ(found[0].message, "topic_rule 1 can never apply: no name matches \"rt/[z-a]\"");
  EXPECT_EQ(found[0].hint, "write what the expression is meant to match, or delete it");
  const auto tagged = changed_strict([](DomainRule& rule) {
    rule.domains.tag_expressions = {{"a\\", 0}};
  });
  const auto tags = of(ddssec::Rule::GOV010, tagged);
  ASSERT_EQ(tags.size(), 1u);
  EXPECT_EQ(tags[0].message, "a <tag_expression> can never apply: no name matches \"a\\\"");
  EXPECT_EQ(tags[0].line, tagged.domain_rules[0].domains.tag_expressions[0].line);
}

TEST(LintGovernance, DeadRulesThatSayTheSame_AreAWarning) {
  const auto found = only(with_rules({strict("rt/*"), strict("rt/a"), strict("*")}));
  EXPECT_EQ(found.rule, ddssec::Rule::GOV010);
  EXPECT_EQ(found.severity, Severity::warning);
}

TEST(LintGovernance, TopicsWithoutARule_HaveAnExample) {
  const auto found = only(with_rules({strict("rt/*"), strict("rq/*")}));
  EXPECT_EQ(found.rule, ddssec::Rule::GOV011);
  EXPECT_EQ(found.message, "the last topic_rule is not \"*\": topics such as \"a\" have no rule");
  EXPECT_TRUE(lint(with_rules({strict("[a-z]*"), strict("[!a-z]*")})).empty());
}

TEST(LintGovernance, ExpressionsThatProductsReadDifferently_AreFound) {
  const auto differs = only(with_rules({strict("rt/[^ab]"), strict("*")}));
  EXPECT_EQ(differs.rule, ddssec::Rule::GOV012);
  EXPECT_EQ(differs.products, std::vector<std::string>{"cyclonedds"});
  EXPECT_EQ(differs.message,
            "\"rt/[^ab]\": a bracket expression holds \"^\"; Cyclone DDS matches \"rt/a\", "
            "which ddssec does not");
  EXPECT_EQ(only(with_rules({strict("rt\\a"), strict("*")})).products,
            (std::vector<std::string>{"cyclonedds", "fastdds"}));
  EXPECT_EQ(only(with_rules({strict("rt]a"), strict("*")})).severity, Severity::informational);
}

TEST(LintGovernance, NamesOfRos_AreFound) {
  EXPECT_EQ(only(with_rules({strict("/chatter"), strict("*")})).rule, ddssec::Rule::GOV013);
}

TEST(LintGovernance, FlagsWithoutAKind_AreFound) {
  const auto document =
      changed_strict([](DomainRule& rule) { rule.discovery_protection_kind = none; });
  EXPECT_EQ(of(ddssec::Rule::GOV020, document).size(), 1u);
  EXPECT_EQ(only(changed_strict([](DomainRule& rule) {
              rule.liveliness_protection_kind = none;
            })).message,
            "\"*\": enable_liveliness_protection is true while liveliness_protection_kind is NONE");
}

TEST(LintGovernance, ControlledTopicsWithFreeJoining_AreFound) {
  EXPECT_EQ(
      only(changed_strict([](DomainRule& rule) { rule.enable_join_access_control = false; })).rule,
      ddssec::Rule::GOV021);
}

TEST(LintGovernance, ProtectedMessagesWithStrangersAllowed_AreFound) {
  const auto document =
      changed_strict([](DomainRule& rule) { rule.allow_unauthenticated_participants = true; });
  const auto found = of(ddssec::Rule::GOV022, document);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].severity, Severity::error);
  EXPECT_NE(found[0].message.find("rtps_protection_kind is SIGN"), std::string::npos);
  EXPECT_TRUE(has_errors(lint(document)));
  EXPECT_EQ(of(ddssec::Rule::GOV025, document).size(), 1u);
  EXPECT_TRUE(of(ddssec::Rule::GOV022, governance_of(Profile::open, {{0, 0}})).empty());
}

TEST(LintGovernance, OriginAuthentication_IsNoted) {
  const auto found = only(changed_strict([](DomainRule& rule) {
    rule.topic_rules[0].metadata_protection_kind = encrypt_with_origin_authentication;
  }));
  EXPECT_EQ(found.rule, ddssec::Rule::GOV030);
  EXPECT_EQ(found.products, (std::vector<std::string>{"opendds", "fastdds"}));
  EXPECT_EQ(of(ddssec::Rule::GOV030, changed_strict([](DomainRule& rule) {
                 rule.rtps_protection_kind = sign_with_origin_authentication;
                 rule.discovery_protection_kind = sign_with_origin_authentication;
               }))
                .size(),
            2u);
}

// T44 (docs/attacks.md): lint reports it as a note, and only if the caller asks for what a document
// leaves open.
TEST(LintGovernance, ReadersThatCanWrite_AreNotedOnRequest) {
  const GovernanceUse use{.choices = true};
  const auto notes = of(ddssec::Rule::GOV042, changed_strict([](auto&) {}), use);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_EQ(notes[0].severity, Severity::informational);
  EXPECT_EQ(notes[0].message,
            "\"*\": writing is controlled, and each permitted reader has the key to write in a "
            "writer's name");
  std::vector<TopicRule> rules;
  for (const auto* name : {"a", "b", "c", "d", "e", "*"}) rules.push_back(strict(name));
  rules[1].metadata_protection_kind = sign_with_origin_authentication;
  rules[2].enable_write_access_control = false;
  const auto several = of(ddssec::Rule::GOV042, with_rules(rules), use);
  ASSERT_EQ(several.size(), 1u);
  EXPECT_TRUE(several[0].message.starts_with("\"a\", \"d\", \"e\" and 1 more: "));
  EXPECT_TRUE(of(ddssec::Rule::GOV042, changed_strict([](DomainRule& rule) {
                   rule.rtps_protection_kind = sign_with_origin_authentication;
                 }),
                 use)
                  .empty());
  EXPECT_TRUE(of(ddssec::Rule::GOV042, governance_of(Profile::open, {{0, 0}}), use).empty());
}

// Moving such a rule would only leave a finding about another one.
TEST(LintGovernance, DeadRuleThatCannotBeMoved_IsToBeDeleted) {
  const auto hint_of = [](std::vector<TopicRule> rules) {
    const auto found = of(ddssec::Rule::GOV010, with_rules(std::move(rules)));
    return found.size() == 1 ? found[0].hint : std::to_string(found.size()) + " findings";
  };
  EXPECT_EQ(hint_of({strict("a*"), strict("a*"), strict("*")}),
            "delete it, or rule 1 if this one is meant to count: moved before that rule, it would "
            "take all of its names");
  EXPECT_TRUE(hint_of({strict("[a-m]*"), strict("[n-z]*"), strict("[a-z]*"), strict("*")})
                  .starts_with("delete it, or rule 1 "));
  EXPECT_EQ(hint_of({strict("a*"), strict("ab*"), strict("*")}), "") << "the rule's own";
  EXPECT_TRUE(
      of(ddssec::Rule::GOV010, with_rules({strict("ab*"), strict("a*"), strict("*")})).empty())
      << "moved";
  EXPECT_TRUE(of(ddssec::Rule::GOV010, with_rules({strict("a*"), strict("*")})).empty())
      << "deleted";
}

TEST(LintGovernance, RemedyAgainstForgedDiscovery_RemovesTheFinding) {
  const GovernanceUse use{.choices = true};
  for (const auto kind : {sign, encrypt}) {
    const auto document = changed_strict([&](DomainRule& rule) {
      const auto raised =
          kind == sign ? sign_with_origin_authentication : encrypt_with_origin_authentication;
      rule.discovery_protection_kind = rule.liveliness_protection_kind = raised;
      rule.rtps_protection_kind = none;
    });
    EXPECT_TRUE(of(ddssec::Rule::GOV044, document, use).empty());
  }
}

TEST(LintGovernance, DiscoveryThatEveryParticipantCanForge_IsNotedOnRequest) {
  const GovernanceUse use{.choices = true};
  const auto of_kinds = [&](ProtectionKind discovery, ProtectionKind liveliness,
                            ProtectionKind rtps) {
    return of(ddssec::Rule::GOV044, changed_strict([&](DomainRule& rule) {
                rule.discovery_protection_kind = discovery;
                rule.liveliness_protection_kind = liveliness;
                rule.rtps_protection_kind = rtps;
              }),
              use);
  };
  const auto both = of_kinds(encrypt, sign, encrypt);
  ASSERT_EQ(both.size(), 1u);
  EXPECT_EQ(both[0].severity, Severity::informational);
  EXPECT_EQ(both[0].message,
            "discovery_protection_kind is ENCRYPT and liveliness_protection_kind is SIGN: each "
            "participant that may join has the keys to send such messages in the name of any "
            "other");
  const auto one = of_kinds(encrypt_with_origin_authentication, encrypt, none);
  ASSERT_EQ(one.size(), 1u);
  EXPECT_TRUE(one[0].message.starts_with("liveliness_protection_kind is ENCRYPT: "));
  EXPECT_TRUE(of_kinds(encrypt, encrypt, sign_with_origin_authentication).empty());
  EXPECT_TRUE(
      of_kinds(encrypt_with_origin_authentication, sign_with_origin_authentication, none).empty());
  EXPECT_TRUE(of_kinds(none, none, encrypt).empty());
  // The caller does not ask for it.
  EXPECT_TRUE(of(ddssec::Rule::GOV044, changed_strict([](auto&) {})).empty());
}

TEST(LintGovernance, ClearDiscoveryBesideProtectedTopics_IsFound) {
  const auto of_flags = [](std::vector<bool> flags, ProtectionKind kind = encrypt) {
    return of(ddssec::Rule::GOV045, changed_strict([&](DomainRule& rule) {
                rule.discovery_protection_kind = kind;
                rule.topic_rules.clear();
                for (const bool flag : flags) {
                  rule.topic_rules.push_back(strict("t" + std::to_string(rule.topic_rules.size())));
                  rule.topic_rules.back().enable_discovery_protection = flag;
                }
              }));
  };
  const auto mixed = of_flags({true, false, true, false});
  ASSERT_EQ(mixed.size(), 1u);
  EXPECT_EQ(mixed[0].severity, Severity::warning);
  EXPECT_EQ(mixed[0].products, std::vector<std::string>{"cyclonedds"});
  EXPECT_TRUE(mixed[0].message.starts_with(
      "\"t1\" and 1 more: enable_discovery_protection is false, so that clear discovery stays "));
  EXPECT_TRUE(mixed[0].path.ends_with("topic_rule[2]"));
  EXPECT_TRUE(of_flags({true, true}).empty());
  EXPECT_EQ(of_flags({false, false}).size(), 1u);
}

TEST(LintGovernance, ClearDiscovery_IsReportedOnlyBesideWhatIsProtected) {
  const auto of_kinds = [](ProtectionKind rtps, ProtectionKind liveliness, ProtectionKind metadata,
                           ProtectionKind data) {
    return of(ddssec::Rule::GOV045, changed_strict([&](DomainRule& rule) {
                rule.discovery_protection_kind = none;
                rule.rtps_protection_kind = rtps;
                rule.liveliness_protection_kind = liveliness;
                rule.topic_rules = {strict("Square")};
                rule.topic_rules[0].metadata_protection_kind = metadata;
                rule.topic_rules[0].data_protection_kind = data;
              }));
  };
  EXPECT_TRUE(of_kinds(none, none, none, none).empty());
  for (const auto& found :
       {of_kinds(encrypt, none, none, none), of_kinds(none, sign, none, none),
        of_kinds(none, none, encrypt, none), of_kinds(none, none, none, encrypt)}) {
    ASSERT_EQ(found.size(), 1u);
    EXPECT_TRUE(found[0].message.starts_with("discovery_protection_kind is NONE beside "));
    EXPECT_EQ(found[0].products, std::vector<std::string>{"cyclonedds"});
  }
}

TEST(LintGovernance, StrangersBesideWhatIsProtected_AreReported) {
  const auto of_kinds = [](bool strangers, ProtectionKind discovery, ProtectionKind metadata,
                           ProtectionKind rtps) {
    return of(ddssec::Rule::GOV047, changed_strict([&](DomainRule& rule) {
                rule.allow_unauthenticated_participants = strangers;
                rule.discovery_protection_kind = discovery;
                rule.liveliness_protection_kind = none;
                rule.rtps_protection_kind = rtps;
                rule.topic_rules = {strict("Square")};
                rule.topic_rules[0].metadata_protection_kind = metadata;
                rule.topic_rules[0].data_protection_kind = none;
              }));
  };
  const auto found = of_kinds(true, none, sign, none);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].severity, Severity::warning);
  EXPECT_EQ(found[0].products, std::vector<std::string>{"cyclonedds"});
  EXPECT_EQ(of_kinds(true, encrypt, none, none).size(), 1u);
  EXPECT_TRUE(of_kinds(false, encrypt, sign, none).empty());
  EXPECT_TRUE(of_kinds(true, none, none, none).empty()) << "GOV040 says so";
  EXPECT_TRUE(of_kinds(true, encrypt, sign, encrypt).empty()) << "GOV022 says so";
}

TEST(LintGovernance, MessagesThatAnAttackerCanRedirect_AreFound) {
  struct Kinds {
    ProtectionKind discovery = none, liveliness = none, metadata = none, rtps = none;
  };
  const auto of_kinds = [](const Kinds& kinds) {
    return of(ddssec::Rule::GOV046, changed_strict([&](DomainRule& rule) {
                rule.discovery_protection_kind = kinds.discovery;
                rule.liveliness_protection_kind = kinds.liveliness;
                rule.rtps_protection_kind = kinds.rtps;
                rule.topic_rules = {strict("open"), strict("Square")};
                rule.topic_rules[0].metadata_protection_kind = none;
                rule.topic_rules[1].metadata_protection_kind = kinds.metadata;
              }));
  };
  const auto all = of_kinds({.discovery = encrypt, .liveliness = sign, .metadata = encrypt});
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].severity, Severity::warning);
  EXPECT_TRUE(all[0].message.starts_with(
      "discovery_protection_kind, liveliness_protection_kind, metadata_protection_kind of "
      "\"Square\" without origin authentication, while rtps_protection_kind is NONE: "));
  EXPECT_EQ(of_kinds({.discovery = sign}).size(), 1u);
  EXPECT_EQ(of_kinds({.liveliness = encrypt}).size(), 1u);
  EXPECT_EQ(of_kinds({.metadata = sign}).size(), 1u);
  EXPECT_TRUE(of_kinds({}).empty());
  for (const auto rtps : {sign, encrypt, sign_with_origin_authentication})
    EXPECT_TRUE(of_kinds({encrypt, encrypt, encrypt, rtps}).empty());
  const auto origin = encrypt_with_origin_authentication;
  EXPECT_TRUE(of_kinds({origin, sign_with_origin_authentication, origin, none}).empty());
  EXPECT_EQ(of_kinds({origin, origin, encrypt, none}).size(), 1u);
  for (const auto profile : {Profile::open, Profile::balanced, Profile::strict})
    EXPECT_TRUE(of(ddssec::Rule::GOV046, governance_of(profile, {{0, 0}})).empty());
}

TEST(LintGovernance, DataProtectionAlone_IsFound) {
  const auto found_under = [](ProtectionKind rtps) {
    return of(ddssec::Rule::GOV031, changed_strict([&](DomainRule& rule) {
                rule.rtps_protection_kind = rtps;
                rule.topic_rules[0].metadata_protection_kind = none;
              }))
        .at(0);
  };
  EXPECT_TRUE(found_under(none).message.contains("anyone on the network can dispose"));
  EXPECT_TRUE(found_under(sign).message.contains("each participant that may join"));
  for (const auto rtps : {none, sign}) {
    EXPECT_EQ(found_under(rtps).severity, ddssec::Severity::warning);
    EXPECT_TRUE(found_under(rtps).products.empty());
  }
  const auto bound = found_under(sign_with_origin_authentication);
  EXPECT_EQ(bound.products, (std::vector<std::string>{"cyclonedds", "fastdds"}));
  EXPECT_FALSE(bound.message.contains("dispose"));
}

TEST(LintGovernance, AccessControlWithoutProtection_IsFound) {
  const auto plain = [](auto&& change) {
    return of(ddssec::Rule::GOV043, changed_strict([&](DomainRule& rule) {
                auto& topic = rule.topic_rules[0];
                topic.metadata_protection_kind = topic.data_protection_kind = none;
                change(rule);
              }));
  };
  const auto found = plain([](auto&) {});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].severity, Severity::warning);
  EXPECT_EQ(found[0].products, std::vector<std::string>{"cyclonedds"});
  // If messages are protected, a participant has one key for everything that it sends.
  EXPECT_EQ(plain([](DomainRule& rule) { rule.rtps_protection_kind = encrypt; }).size(), 1u);
  EXPECT_EQ(plain([](DomainRule& rule) {
              rule.topic_rules[0].enable_read_access_control = false;
            }).size(),
            1u);
  EXPECT_TRUE(plain([](DomainRule& rule) {
                rule.topic_rules[0].enable_read_access_control = false;
                rule.topic_rules[0].enable_write_access_control = false;
              }).empty());
  EXPECT_TRUE(of(ddssec::Rule::GOV043, changed_strict([](DomainRule& rule) {
                   rule.topic_rules[0].metadata_protection_kind = none;
                   rule.topic_rules[0].data_protection_kind = sign;
                 }))
                  .empty());
}

TEST(LintGovernance, EncryptionWithoutReadControl_IsFound) {
  EXPECT_EQ(only(changed_strict([](DomainRule& rule) {
              rule.topic_rules[0].enable_read_access_control = false;
            })).rule,
            ddssec::Rule::GOV041);
}

struct Spelling {
  const char *from, *to;
  ddssec::Rule id;
};

class SpellingOfGovernance : public ::testing::TestWithParam<Spelling> {};

TEST_P(SpellingOfGovernance, EachSpelling_IsFoundAtItsLine) {
  const auto& [from, to, id] = GetParam();
  const auto xml = to_xml(governance_of(Profile::strict, {{0, 0}}));
  const auto document = governance_from(replaced(xml, from, to));
  ASSERT_TRUE(document) << document.error().to_sentence();
  const auto found = only(*document);
  EXPECT_EQ(found.rule, id);
  EXPECT_GT(found.line, 0);
}

INSTANTIATE_TEST_SUITE_P(
    All, SpellingOfGovernance,
    ::testing::Values(Spelling{"<id>0</id>", "<id_range><min>0</min></id_range>",
                               ddssec::Rule::GOV004},
                      Spelling{">SIGN<", "> SIGN<", ddssec::Rule::GOV005},
                      Spelling{"<id>0</id>", "<id>0</id><tag></tag>", ddssec::Rule::GOV006},
                      Spelling{"control>true", "control>TRUE", ddssec::Rule::GOV023},
                      Spelling{">SIGN<", ">Sign<", ddssec::Rule::GOV024}));

TEST(LintGovernance, OrderOfElements_IsFoundForFastDds) {
  const std::string first = "<topic_expression>*</topic_expression>";
  auto xml = replaced(to_xml(governance_of(Profile::strict, {{0, 0}})), first, "");
  xml = replaced(xml, "</data_protection_kind>", "</data_protection_kind>" + first);
  const auto found = only(*governance_from(xml));
  EXPECT_EQ(found.rule, ddssec::Rule::GOV001);
  EXPECT_EQ(found.products, std::vector<std::string>{"fastdds"});
}

TEST(LintGovernance, FindingsOfOneKind_HaveABound) {
  std::vector<TopicRule> rules(100, strict("/a"));
  for (std::size_t i = 0; i < rules.size(); ++i) rules[i].topic_expression += std::to_string(i);
  rules.push_back(strict("*"));
  const auto found = of(ddssec::Rule::GOV013, with_rules(rules));
  ASSERT_EQ(found.size(), kMaxFindingsPerRule);
  EXPECT_TRUE(found.back().message.ends_with(" (and 80 more like this)"));
}

}  // namespace
}  // namespace ddssec::governance
