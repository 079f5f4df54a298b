#include "governance/decision.hpp"

#include <fnmatch.h>
#include <random>

#include "tests/unit/governance/governance_fixture.hpp"

namespace ddssec::governance {
namespace {

using Names = std::vector<std::string_view>;

Criteria criteria(std::vector<std::string> topics,
                  std::optional<std::vector<std::string>> partitions = {},
                  std::optional<std::vector<DataTag>> tags = {}) {
  Criteria out;
  for (auto& topic : topics) out.topics.push_back({std::move(topic), 0});
  if (partitions) {
    out.partitions.emplace();
    for (auto& partition : *partitions) out.partitions->push_back({std::move(partition), 0});
  }
  out.data_tags = std::move(tags);
  return out;
}

GrantRule rule(bool allow, std::vector<Criteria> publish, DomainRange domains = {0, 230}) {
  GrantRule out;
  out.allow = allow;
  out.domains.ranges = {domains};
  out.publish = std::move(publish);
  return out;
}

CompiledGrant compiled(std::vector<GrantRule> rules, bool default_allow = false,
                       PartitionMatch match = PartitionMatch::all, DomainId domain = 0) {
  auto permissions = std::make_shared<Permissions>();
  auto& grant = permissions->grants.emplace_back();
  grant.rules = std::move(rules);
  grant.default_allow = default_allow;
  return CompiledGrant(permissions, grant, domain, match);
}

bool may_publish(const CompiledGrant& grant, std::string_view topic, const Names& partitions = {},
                 const std::vector<DataTag>& tags = {}) {
  return grant.judge(Action::publish, {topic, partitions, tags}).allowed;
}

TEST(Decision, Default_CountsWhereNoRuleMatches) {
  EXPECT_FALSE(may_publish(compiled({}), "t"));
  EXPECT_TRUE(may_publish(compiled({}, true), "t"));
  EXPECT_EQ(compiled({}, true).judge(Action::publish, {"t"}).rule, nullptr);
}

// T6 (docs/attacks.md): the last rule wins instead of the first.
TEST(Decision, FirstRule_Wins) {
  const auto allow = rule(true, {criteria({"a*"})});
  const auto deny = rule(false, {criteria({"*b"})});
  EXPECT_TRUE(may_publish(compiled({allow, deny}), "ab"));
  EXPECT_FALSE(may_publish(compiled({deny, allow}), "ab"));
  EXPECT_TRUE(may_publish(compiled({deny, allow}), "ac"));
  EXPECT_FALSE(may_publish(compiled({deny, allow}, true), "cb"));
  const auto literal_allow = rule(true, {criteria({"ab"})});
  EXPECT_TRUE(may_publish(compiled({literal_allow, deny}), "ab"));
  EXPECT_FALSE(may_publish(compiled({deny, literal_allow}), "ab"));
}

TEST(Decision, Verdict_TellsTheLineThatDecided) {
  auto permissions = permissions_from(kPermissionsXml);
  ASSERT_TRUE(permissions);
  const auto shared = std::make_shared<const Permissions>(*permissions);
  const CompiledGrant grant(shared, shared->grants[0], 3);
  const Names partition = {"a1"};
  const auto decision = grant.judge(Action::publish, {"Square", partition, {}});
  EXPECT_TRUE(decision.allowed);
  EXPECT_EQ(decision.line(grant.grant()), 12);
  EXPECT_EQ(grant.judge(Action::publish, {"Circle"}).line(grant.grant()), 23);
}

TEST(Decision, Actions_AreApart) {
  auto mixed = rule(true, {criteria({"p"})});
  mixed.subscribe = {criteria({"s"})};
  mixed.relay = {criteria({"r"})};
  const auto grant = compiled({mixed});
  const auto may = [&](Action action, std::string_view topic) {
    return grant.judge(action, {topic}).allowed;
  };
  for (const auto action : {Action::publish, Action::subscribe, Action::relay}) {
    EXPECT_EQ(may(action, "p"), action == Action::publish) << to_string(action);
    EXPECT_EQ(may(action, "s"), action == Action::subscribe) << to_string(action);
    EXPECT_EQ(may(action, "r"), action == Action::relay) << to_string(action);
  }
}

TEST(Decision, RulesOfOtherDomains_DoNotCount) {
  const auto deny = rule(false, {criteria({"*"})}, {1, 1});
  const auto allow = rule(true, {criteria({"*"})}, {0, 1});
  EXPECT_TRUE(may_publish(compiled({deny, allow}), "t"));
  EXPECT_FALSE(may_publish(compiled({deny, allow}, false, PartitionMatch::all, 1), "t"));
  EXPECT_FALSE(may_publish(compiled({allow}, false, PartitionMatch::all, 2), "t"));
}

// Topic, partitions and tags must fit in the same element.
TEST(Decision, Elements_AreNotMixed) {
  const auto grant = compiled({rule(true, {criteria({"a"}, {{"p"}}), criteria({"b"}, {{"q"}})})});
  EXPECT_TRUE(may_publish(grant, "a", {"p"}));
  EXPECT_TRUE(may_publish(grant, "b", {"q"}));
  EXPECT_FALSE(may_publish(grant, "a", {"q"}));
  EXPECT_FALSE(may_publish(grant, "b", {"p"}));
}

TEST(Partitions, AllowRules_MustListThem) {
  const auto none = compiled({rule(true, {criteria({"t"})})});
  EXPECT_TRUE(may_publish(none, "t"));
  EXPECT_TRUE(may_publish(none, "t", {""}));
  EXPECT_FALSE(may_publish(none, "t", {"p"}));
  EXPECT_FALSE(may_publish(none, "t", {"", "p"}));

  const auto listed = compiled({rule(true, {criteria({"t"}, {{"p*", "q"}})})});
  EXPECT_TRUE(may_publish(listed, "t", {"p1"}));
  EXPECT_TRUE(may_publish(listed, "t", {"p1", "q"}));
  EXPECT_FALSE(may_publish(listed, "t", {"p1", "r"}));
  EXPECT_FALSE(may_publish(listed, "t"));

  const auto star = compiled({rule(true, {criteria({"t"}, {{"*"}})})});
  EXPECT_TRUE(may_publish(star, "t"));
  EXPECT_TRUE(may_publish(star, "t", {"any", "other"}));

  const auto empty = compiled({rule(true, {criteria({"t"}, {{"", "p"}})})});
  EXPECT_TRUE(may_publish(empty, "t"));
  EXPECT_TRUE(may_publish(empty, "t", {"p", ""}));
}

TEST(Partitions, LegacyMode_NeedsOneMatchOnly) {
  const auto grant = compiled({rule(true, {criteria({"t"}, {{"p"}})})}, false, PartitionMatch::one);
  EXPECT_TRUE(may_publish(grant, "t", {"p", "r"}));
  EXPECT_FALSE(may_publish(grant, "t", {"r"}));
}

// Deny rules must not be evaluated as allow rules are (Cyclone DDS pull request 706).
TEST(Partitions, DenyRules_HitAnyOfThem) {
  const auto any = compiled({rule(false, {criteria({"t"})})}, true);
  EXPECT_FALSE(may_publish(any, "t"));
  EXPECT_FALSE(may_publish(any, "t", {"p"}));

  const auto listed = compiled({rule(false, {criteria({"t"}, {{"p"}})})}, true);
  EXPECT_FALSE(may_publish(listed, "t", {"p"}));
  EXPECT_FALSE(may_publish(listed, "t", {"q", "p"}));
  EXPECT_TRUE(may_publish(listed, "t", {"q"}));
  EXPECT_TRUE(may_publish(listed, "t"));

  const auto empty = compiled({rule(false, {criteria({"t"}, {{""}})})}, true);
  EXPECT_FALSE(may_publish(empty, "t"));
  EXPECT_TRUE(may_publish(empty, "t", {"p"}));
}

// T5 (docs/attacks.md): a partition with wildcards stands for many names.
TEST(Partitions, RequestedWildcards_MustBeCovered) {
  const auto grant = compiled({rule(true, {criteria({"t"}, {{"s?", "a*", "x[1]", "*y"}})})});
  EXPECT_FALSE(may_publish(grant, "t", {"s*"}));
  EXPECT_TRUE(may_publish(grant, "t", {"s?"}));
  EXPECT_TRUE(may_publish(grant, "t", {"a*"}));
  EXPECT_TRUE(may_publish(grant, "t", {"ab?"}));
  EXPECT_FALSE(may_publish(grant, "t", {"?b"}));
  EXPECT_FALSE(may_publish(grant, "t", {"*"}));
  EXPECT_TRUE(may_publish(grant, "t", {"x[1]"}));
  EXPECT_FALSE(may_publish(grant, "t", {"?y"}));
  const auto star = compiled({rule(true, {criteria({"t"}, {{"*"}})})});
  EXPECT_TRUE(may_publish(star, "t", {"*"}));
  EXPECT_TRUE(may_publish(star, "t", {"[a-z]?"}));
}

TEST(Partitions, RequestedWildcards_AreHitByDenyRules) {
  const auto grant = compiled({rule(false, {criteria({"t"}, {{"secret"}})})}, true);
  EXPECT_FALSE(may_publish(grant, "t", {"s*"}));
  EXPECT_FALSE(may_publish(grant, "t", {"*"}));
  EXPECT_TRUE(may_publish(grant, "t", {"p*"}));
  const auto wild = compiled({rule(false, {criteria({"t"}, {{"secret*"}})})}, true);
  EXPECT_FALSE(may_publish(wild, "t", {"p*"}));
}

TEST(DataTagRules, AllowRules_MustHoldAll) {
  const std::vector<DataTag> red = {{"colour", "red"}}, both = {{"colour", "red"}, {"size", "5"}};
  const auto none = compiled({rule(true, {criteria({"t"})})});
  EXPECT_TRUE(may_publish(none, "t"));
  EXPECT_FALSE(may_publish(none, "t", {}, red));
  const auto listed = compiled({rule(true, {criteria({"t"}, {}, red)})});
  EXPECT_TRUE(may_publish(listed, "t"));
  EXPECT_TRUE(may_publish(listed, "t", {}, red));
  EXPECT_FALSE(may_publish(listed, "t", {}, both));
  EXPECT_FALSE(may_publish(listed, "t", {}, {{"colour", "RED"}}));
}

TEST(DataTagRules, DenyRules_HitAny) {
  const std::vector<DataTag> red = {{"colour", "red"}}, both = {{"colour", "red"}, {"size", "5"}};
  const auto any = compiled({rule(false, {criteria({"t"})})}, true);
  EXPECT_FALSE(may_publish(any, "t", {}, red));
  const auto listed = compiled({rule(false, {criteria({"t"}, {}, red)})}, true);
  EXPECT_TRUE(may_publish(listed, "t"));
  EXPECT_FALSE(may_publish(listed, "t", {}, red));
  EXPECT_FALSE(may_publish(listed, "t", {}, both));
  EXPECT_TRUE(may_publish(listed, "t", {}, {{"size", "5"}}));
}

TEST(Decision, CachedVerdict_DependsOnEachPartOfTheQuestion) {
  const auto grant = compiled({rule(true, {criteria({"t"}, {{"p", "pq"}}, {{{"n", "v"}}})})});
  for (int i = 0; i < 2; ++i) {
    EXPECT_TRUE(may_publish(grant, "t", {"p", "pq"})) << "time " << i;
    EXPECT_FALSE(may_publish(grant, "t", {"ppq"})) << "time " << i;
    EXPECT_TRUE(may_publish(grant, "t", {"p"}, {{"n", "v"}})) << "time " << i;
    EXPECT_FALSE(may_publish(grant, "t", {"p"}, {{"nv", ""}})) << "time " << i;
    EXPECT_FALSE(may_publish(grant, "tp", {"q"})) << "time " << i;
    EXPECT_FALSE(grant.judge(Action::subscribe, {"t", Names{"p"}, {}}).allowed) << "time " << i;
  }
}

TEST(ParticipantDecision, AllowRuleOfTheDomain_LetsIn) {
  EXPECT_TRUE(compiled({rule(true, {})}).judge_participant().allowed);
  EXPECT_FALSE(compiled({rule(true, {}, {1, 1})}).judge_participant().allowed);
  EXPECT_FALSE(compiled({}).judge_participant().allowed);
  EXPECT_TRUE(compiled({}, true).judge_participant().allowed);
}

// DDS-Security 1.2 table 70. Deny rules about topics are skipped, because sros2 writes them first.
TEST(ParticipantDecision, DenialOfTopics_DoesNotDecideAndTheNextRuleDoes) {
  const auto everything = rule(false, {});
  const auto topic = rule(false, {criteria({"t"})});
  EXPECT_FALSE(compiled({everything, rule(true, {})}).judge_participant().allowed);
  EXPECT_TRUE(compiled({rule(true, {}), everything}).judge_participant().allowed);
  EXPECT_TRUE(compiled({topic, rule(true, {})}).judge_participant().allowed);
  EXPECT_FALSE(compiled({topic, everything, rule(true, {})}, true).judge_participant().allowed);
  EXPECT_FALSE(compiled({topic}).judge_participant().allowed) << "the default";
  EXPECT_TRUE(compiled({topic, rule(true, {})}, true).judge_participant().allowed);
  EXPECT_TRUE(compiled({rule(true, {}), topic, rule(true, {})}).judge_participant().allowed);
  EXPECT_TRUE(compiled({rule(false, {}, {1, 1}), rule(true, {})}).judge_participant().allowed);
  auto relay = rule(false, {});
  relay.relay = {criteria({"t"})};
  EXPECT_FALSE(compiled({relay}, true).judge_participant().allowed) << "no publish, no subscribe";
  EXPECT_TRUE(compiled({topic}, true).judge_participant().allowed);
  EXPECT_FALSE(compiled({everything}, true).judge_participant().allowed);
}

TEST(Topic, AnyPartitionThatWouldDo_IsEnough) {
  const auto may = [](const CompiledGrant& grant) {
    return grant.judge_topic(Action::publish, "t").allowed;
  };
  const auto partition_denied = rule(false, {criteria({"t"}, {{"p"}})});
  const auto denied = rule(false, {criteria({"t"})});
  const auto allowed = rule(true, {criteria({"t"}, {{"q"}})});
  EXPECT_TRUE(may(compiled({partition_denied, allowed})));
  EXPECT_FALSE(may(compiled({denied, allowed})));
  EXPECT_TRUE(may(compiled({allowed, denied})));
  EXPECT_TRUE(may(compiled({partition_denied}, true)));
  EXPECT_FALSE(may(compiled({partition_denied})));
}

TEST(GovernanceRules, FirstTopicRule_Wins) {
  auto governance = std::make_shared<Governance>();
  auto& domain_rule = governance->domain_rules.emplace_back();
  domain_rule.domains.ranges = {{0, 5}};
  for (const char* expression : {"a*", "ab", "a*", "*"}) {
    TopicRule topic_rule;
    topic_rule.topic_expression = expression;
    topic_rule.line = static_cast<int>(domain_rule.topic_rules.size()) + 1;
    domain_rule.topic_rules.push_back(topic_rule);
  }
  const auto compiled = CompiledGovernance::make(governance, 5);
  ASSERT_TRUE(compiled);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ((*compiled)->topic_rule("ab")->line, 1) << "time " << i;
    EXPECT_EQ((*compiled)->topic_rule("b")->line, 4) << "time " << i;
  }
  const auto none = CompiledGovernance::make(governance, 6);
  EXPECT_CODE(none, domain_not_covered);
  EXPECT_TRUE(none.error().message().ends_with(
      "; the participant is in domain 6, the document covers 0 to 5"));
}

TEST(GovernanceRules, FirstDomainRule_Wins) {
  auto governance = std::make_shared<Governance>();
  for (const DomainRange range : {DomainRange{0, 0}, DomainRange{0, 9}}) {
    auto& rule = governance->domain_rules.emplace_back();
    rule.domains.ranges = {range};
    rule.topic_rules.emplace_back().topic_expression = "x";
  }
  EXPECT_EQ(&(*CompiledGovernance::make(governance, 0))->domain_rule(),
            &governance->domain_rules[0]);
  EXPECT_EQ(&(*CompiledGovernance::make(governance, 9))->domain_rule(),
            &governance->domain_rules[1]);
  EXPECT_EQ((*CompiledGovernance::make(governance, 9))->topic_rule("y"), nullptr);
}

TEST(VerdictCache, ManyEntries_StayBounded) {
  DecisionCache<int> cache;
  for (int i = 0; i < 20'000; ++i) cache.remember(std::to_string(i), i);
  EXPECT_LE(cache.size(), 2 * DecisionCache<int>::kMaxPerGeneration);
  EXPECT_EQ(cache.find("19999"), 19999);
  EXPECT_EQ(cache.find("0"), std::nullopt);
  cache.remember(std::string(5000, 'x'), 1);
  EXPECT_EQ(cache.find(std::string(5000, 'x')), std::nullopt);
}

// A model of the standard's text without any index (T5 and T6 in docs/attacks.md).
bool model_allows(const std::vector<GrantRule>& rules, std::string_view topic,
                  const Names& partitions) {
  const auto hit = [](const Text& text, std::string_view name) {
    return fnmatch(text.text.c_str(), std::string(name).c_str(), 0) == 0;
  };
  for (const auto& rule : rules) {
    for (const auto& element : rule.publish) {
      bool topic_fits = false;
      for (const auto& listed : element.topics) topic_fits |= hit(listed, topic);
      const auto listed = [&](std::string_view partition) {
        if (!element.partitions) return partition.empty();
        return std::ranges::any_of(*element.partitions,
                                   [&](const Text& text) { return hit(text, partition); });
      };
      bool partitions_fit = rule.allow ? std::ranges::all_of(partitions, listed)
                                       : std::ranges::any_of(partitions, listed);
      if (!rule.allow && !element.partitions) partitions_fit = true;
      if (topic_fits && partitions_fit) return rule.allow;
    }
  }
  return false;
}

TEST(Decision, RandomRules_AgreeWithTheModel) {
  std::mt19937 random(7);
  const auto text = [&](std::string_view alphabet, unsigned most) {
    std::string out(random() % (most + 1), ' ');
    for (auto& c : out) c = alphabet[random() % alphabet.size()];
    return out;
  };
  int allowed = 0;
  for (int round = 0; round < 2000; ++round) {
    std::vector<GrantRule> rules;
    for (unsigned r = 0; r < 1 + random() % 8; ++r) {
      std::vector<Criteria> elements;
      for (unsigned e = 0; e < 1 + random() % 3; ++e) {
        std::optional<std::vector<std::string>> partitions;
        if (random() % 2) partitions = {text("pq*?", 2), text("pq*", 3)};
        elements.push_back(criteria({text("ab*?", 3) + "a", text("ab[]*", 4) + "b"}, partitions));
      }
      rules.push_back(rule(random() % 2, elements));
    }
    const auto grant = compiled(rules);
    for (int i = 0; i < 60; ++i) {
      const auto topic = text("ab", 4);
      const auto first = text("pq", 2), second = text("pq", 2);
      const Names partitions = random() % 2 ? Names{first} : Names{first, second};
      const bool expected = model_allows(rules, topic, partitions);
      ASSERT_EQ(may_publish(grant, topic, partitions), expected) << topic << " in " << first;
      allowed += expected;
    }
  }
  EXPECT_GT(allowed, 1000);
}

}  // namespace
}  // namespace ddssec::governance
