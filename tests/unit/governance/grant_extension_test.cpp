// Grants that allow at least what former ones allowed.
#include "governance/grant_extension.hpp"

#include <memory>
#include <random>

#include <gtest/gtest.h>

#include "governance/decision.hpp"

namespace ddssec::governance {
namespace {

std::vector<Text> texts(const std::vector<std::string>& all) {
  std::vector<Text> out;
  for (const auto& one : all) out.push_back({.text = one});
  return out;
}

Criteria on(const std::vector<std::string>& topics) { return {.topics = texts(topics)}; }

Criteria in(std::vector<std::string> topics, const std::vector<std::string>& partitions) {
  auto out = on(topics);
  out.partitions = texts(partitions);
  return out;
}

Criteria tagged(std::vector<std::string> topics, const std::vector<DataTag>& tags) {
  auto out = on(topics);
  out.data_tags = tags;
  return out;
}

GrantRule rule(bool allow, const std::vector<Criteria>& publish,
               const std::vector<Criteria>& subscribe = {}) {
  return {.allow = allow,
          .domains = {.ranges = {{.first = 0, .last = 0}}},
          .publish = publish,
          .subscribe = subscribe};
}

bool at_least(const std::vector<GrantRule>& next, const std::vector<GrantRule>& former,
              bool next_default = false, bool former_default = false) {
  const Grant a{.rules = next}, b{.rules = former};
  const auto rules = rules_for(a, 0, ""), former_rules = rules_for(b, 0, "");
  return gives_at_least({rules, next_default}, {former_rules, former_default});
}

TEST(GrantExtension, TheSameOrMoreTopics_AreAnExtension) {
  const auto a = rule(true, {on({"A"})}), ab = rule(true, {on({"B", "A"})});
  EXPECT_TRUE(at_least({a}, {a}));
  EXPECT_TRUE(at_least({ab}, {a}));
  EXPECT_FALSE(at_least({a}, {ab}));
  EXPECT_FALSE(at_least({}, {a}));
  EXPECT_FALSE(at_least({rule(true, {}, {on({"A"})})}, {a}));
  EXPECT_TRUE(at_least({rule(true, {on({"A"})}, {on({"C"})})}, {a}));
  EXPECT_TRUE(at_least({rule(true, {on({"B"}), on({"A"})})}, {a}));
}

TEST(GrantExtension, FurtherAllowRules_AnywhereAreMore) {
  const auto a = rule(true, {on({"A"})}), b = rule(true, {on({"B"})}),
             no = rule(false, {on({"N"})});
  EXPECT_TRUE(at_least({b, a}, {a}));
  EXPECT_TRUE(at_least({a, b}, {a}));
  EXPECT_TRUE(at_least({no, b, a}, {no, a}));
  EXPECT_TRUE(at_least({a, no}, {a, no}));
}

TEST(GrantExtension, DenyRules_MayLeaveAndShrinkButNotComeOrGrow) {
  const auto a = rule(true, {on({"A*"})});
  const auto n = rule(false, {on({"AN"})}), nm = rule(false, {on({"AN", "AM"})});
  EXPECT_TRUE(at_least({a}, {n, a}));
  EXPECT_TRUE(at_least({n, a}, {nm, a}));
  EXPECT_FALSE(at_least({nm, a}, {n, a}));
  EXPECT_FALSE(at_least({n, a}, {a}));
  EXPECT_FALSE(at_least({n, a}, {a, n}));  // the other order
}

TEST(GrantExtension, TheDefault_CountsAfterAllRules) {
  const auto n = rule(false, {on({"N"})});
  EXPECT_TRUE(at_least({n}, {n}, true, true));
  EXPECT_TRUE(at_least({n}, {n}, true, false));
  EXPECT_FALSE(at_least({n}, {n}, false, true));
  EXPECT_TRUE(at_least({}, {n}, true, true));
}

TEST(GrantExtension, Partitions_OfAllowRulesMayGrow) {
  const auto none = rule(true, {on({"A"})}), p = rule(true, {in({"A"}, {"p"})}),
             pq = rule(true, {in({"A"}, {"q", "p"})});
  EXPECT_TRUE(at_least({pq}, {p}));
  EXPECT_FALSE(at_least({p}, {pq}));
  // An allow rule without partitions is for the partition "".
  EXPECT_FALSE(at_least({none}, {p}));
  EXPECT_FALSE(at_least({p}, {none}));
}

TEST(GrantExtension, Partitions_OfDenyRulesMayOnlyShrink) {
  const auto a = rule(true, {on({"A"})});
  // A deny rule without partitions is for all partitions.
  const auto all = rule(false, {on({"A"})}), p = rule(false, {in({"A"}, {"p"})}),
             pq = rule(false, {in({"A"}, {"p", "q"})});
  EXPECT_TRUE(at_least({p, a}, {all, a}));
  EXPECT_TRUE(at_least({p, a}, {pq, a}));
  EXPECT_FALSE(at_least({all, a}, {p, a}));
  EXPECT_FALSE(at_least({pq, a}, {p, a}));
}

TEST(GrantExtension, DataTags_AreComparedLikePartitions) {
  const DataTag red{"colour", "red"}, blue{"colour", "blue"};
  EXPECT_TRUE(
      at_least({rule(true, {tagged({"A"}, {red, blue})})}, {rule(true, {tagged({"A"}, {red})})}));
  EXPECT_FALSE(
      at_least({rule(true, {tagged({"A"}, {blue})})}, {rule(true, {tagged({"A"}, {red})})}));
  EXPECT_FALSE(at_least({rule(true, {on({"A"})})}, {rule(true, {tagged({"A"}, {red})})}));
}

// A deny rule without publish and subscribe forbids joining.
TEST(GrantExtension, ADenyRuleThatBeginsToForbidJoining_IsLess) {
  const auto a = rule(true, {on({"A"})});
  auto relays = rule(false, {on({"N"})});
  const auto nothing = rule(false, {});
  EXPECT_TRUE(decides_joining(nothing));
  EXPECT_FALSE(at_least({nothing, a}, {relays, a}));
  EXPECT_TRUE(at_least({relays, a}, {nothing, a}) == false);
  EXPECT_TRUE(at_least({a}, {nothing, a}));
}

TEST(GrantExtension, RulesForOtherDomains_DoNotCount) {
  auto other = rule(false, {on({"A"})});
  other.domains.ranges = {{.first = 7, .last = 7}};
  const auto a = rule(true, {on({"A"})});
  EXPECT_TRUE(at_least({other, a}, {a}));
}

TEST(GrantExtension, LongLists_MustBeTheSame) {
  std::vector<std::string> many;
  for (int i = 0; i < 2000; ++i) many.push_back("T" + std::to_string(i));
  const auto long_one = rule(true, {on(many)});
  EXPECT_TRUE(at_least({long_one}, {long_one}));
  EXPECT_FALSE(at_least({long_one}, {rule(true, {on({"T1"})})}));
}

Grant grant_of(const std::string& subject, const std::vector<GrantRule>& rules) {
  return {.name = "of " + subject, .subject_name = subject, .rules = rules};
}

TEST(GrantExtension, GrantsThatDifferInNameAndValidity_GiveTheSame) {
  const auto a = rule(true, {on({"A"})});
  auto next = grant_of("CN=a", {a});
  next.name = "another";
  next.validity.not_after += std::chrono::hours(1);
  EXPECT_TRUE(give_same_rights(next, grant_of("CN=a", {a})));
  EXPECT_FALSE(give_same_rights(next, grant_of("CN=b", {a})));
  EXPECT_FALSE(give_same_rights(next, grant_of("CN=a", {a, a})));
}

TEST(GrantExtension, GrantWithMoreRights_GivesAtLeastTheFormerOnes) {
  const auto a = rule(true, {on({"A"})}), ab = rule(true, {on({"B", "A"})});
  EXPECT_TRUE(gives_at_least(grant_of("CN=a", {ab}), grant_of("CN=a", {a})));
  EXPECT_FALSE(gives_at_least(grant_of("CN=a", {a}), grant_of("CN=a", {ab})));
  EXPECT_FALSE(gives_at_least(grant_of("CN=b", {ab}), grant_of("CN=a", {a})));
  EXPECT_FALSE(gives_at_least(grant_of("CN=a", {ab}), grant_of("CN=a", {})));
}

TEST(GrantExtension, RulesForDifferentDomains_PassOnlyIfTheGrantsAreEqual) {
  const auto a = rule(true, {on({"A"})}), ab = rule(true, {on({"B", "A"})});
  auto other = a;
  other.domains.ranges = {{.first = 7, .last = 7}};
  EXPECT_TRUE(gives_at_least(grant_of("CN=a", {a, other}), grant_of("CN=a", {a, other})));
  EXPECT_FALSE(gives_at_least(grant_of("CN=a", {ab, other}), grant_of("CN=a", {a, other})));
}

// ---- compared by their decisions

// Small random grants. Each list is drawn from few names, so that many pairs are comparable.
struct RandomGrants {
  std::size_t below(std::size_t bound) { return random() % bound; }
  template <class One>
  std::vector<One> some(const std::vector<One>& all) {
    std::vector<One> out;
    for (const auto& one : all)
      if (below(2) == 0) out.push_back(one);
    return out;
  }
  Criteria criteria() {
    Criteria out = on(some<std::string>({"A", "B", "A*"}));
    if (below(3) == 0) out.partitions = texts(some<std::string>({"p", "q", "*"}));
    if (below(4) == 0) out.data_tags = some<DataTag>({{"t", "1"}, {"t", "2"}});
    return out;
  }
  std::vector<Criteria> several() {
    std::vector<Criteria> out(below(3));
    for (auto& one : out) one = criteria();
    return out;
  }
  Grant grant() {
    Grant out{.default_allow = below(4) == 0};
    for (auto count = below(4); count > 0; --count)
      out.rules.push_back(rule(below(3) != 0, several(), several()));
    return out;
  }
  // Returns the same grant with some random changes.
  Grant changed(Grant grant) {
    if (below(2) == 0) {
      const auto at =
          grant.rules.begin() + static_cast<std::ptrdiff_t>(below(grant.rules.size() + 1));
      grant.rules.insert(at, rule(below(2) == 0, several(), several()));
    }
    for (auto& one : grant.rules) {
      if (below(3) != 0 || one.publish.empty()) continue;
      auto& criteria = one.publish.front();
      if (below(2) == 0)
        criteria.topics.push_back({.text = "B"});
      else if (!criteria.topics.empty())
        criteria.topics.pop_back();
      if (criteria.partitions && below(2) == 0) criteria.partitions->push_back({.text = "q"});
    }
    if (!grant.rules.empty() && below(4) == 0)
      grant.rules.erase(grant.rules.begin() +
                        static_cast<std::ptrdiff_t>(below(grant.rules.size())));
    return grant;
  }
  std::minstd_rand random{7};
};

// True if `next` allows all that `former` allows, judged by some endpoints.
bool nothing_is_lost(const Grant& next, const Grant& former) {
  const auto compiled = [](const Grant& grant) {
    auto document = std::make_shared<Permissions>(Permissions{.grants = {grant}});
    return CompiledGrant(document, document->grants.front(), 0);
  };
  const auto a = compiled(next), b = compiled(former);
  if (b.judge_participant().allowed && !a.judge_participant().allowed) return false;
  const std::vector<std::vector<std::string_view>> partitions = {{},         {"p"}, {"q"},
                                                                 {"p", "q"}, {"r"}, {"p*"}};
  const std::vector<std::vector<DataTag>> tags = {
      {}, {{"t", "1"}}, {{"t", "1"}, {"t", "2"}}, {{"u", "1"}}};
  for (const auto action : {Action::publish, Action::subscribe})
    for (const auto* topic : {"A", "AB", "B", "C"})
      for (const auto& in : partitions)
        for (const auto& with : tags)
          if (b.judge(action, {topic, in, with}).allowed &&
              !a.judge(action, {topic, in, with}).allowed)
            return false;
  return true;
}

TEST(GrantExtension, RandomGrants_NoneThatGivesLessIsTakenForOne) {
  RandomGrants random;
  int taken = 0, refused = 0;
  for (int i = 0; i < 20'000; ++i) {
    const auto former = random.grant(), next = random.changed(former);
    if (at_least(next.rules, former.rules, next.default_allow, former.default_allow)) {
      ++taken;
      ASSERT_TRUE(nothing_is_lost(next, former)) << i;
    } else {
      ++refused;
    }
  }
  EXPECT_GT(taken, 1000);
  EXPECT_GT(refused, 1000);
}

}  // namespace
}  // namespace ddssec::governance
