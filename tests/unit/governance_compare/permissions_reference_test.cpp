// The comparison of permissions documents is checked against a model that tries every short topic,
// every set of partitions, every subject, domain and time, and against the decisions of the
// plugins.
#include <bitset>
#include <map>
#include <memory>
#include <set>

#include <gtest/gtest.h>

#include "governance/compare/permissions_diff.hpp"
#include "governance/decision.hpp"
#include "tests/unit/governance_compare/words.hpp"

namespace ddssec::governance {
namespace {

constexpr DomainId kDomains = 2;  // 0 and 1, and 9 for all others
constexpr const char* kTags[] = {"", "a", "b"};
const DataTag kDataTags[] = {{"n", "1"}, {"n", "2"}, {"n", "3"}};  // the last one is not listed
constexpr int kTimes = 4;
constexpr const char* kSubjects[] = {"CN=a", "CN=b"};

WallTime at(int time) { return WallTime(std::chrono::seconds(time)); }

const words::Pool& topics() {
  static const words::Pool pool(5, 2);
  return pool;
}
const words::Pool& partitions() {
  static const words::Pool pool(3, 2);
  return pool;
}

class Author {
 public:
  Author(std::uint32_t seed, bool with_partitions)
      : dice_(seed), with_partitions_(with_partitions) {}

  Permissions document() {
    Permissions permissions;
    for (auto grants = 1 + dice_.below(with_partitions_ ? 1 : 3); grants > 0; --grants) {
      permissions.grants.push_back(grant());
    }
    return permissions;
  }

  Permissions edited(Permissions permissions) {
    for (auto edits = dice_.below(3); edits > 0; --edits) {
      auto& grant = permissions.grants[dice_.below(permissions.grants.size())];
      edit(grant);
    }
    return permissions;
  }

 private:
  Criteria criteria() {
    Criteria criteria;
    for (auto count = 1 + dice_.below(2); count > 0; --count) {
      criteria.topics.push_back({dice_.once_in(4) ? "*" : topics().random(dice_)});
    }
    if (!with_partitions_) return criteria;
    while (dice_.once_in(4)) {
      if (!criteria.data_tags) criteria.data_tags.emplace();
      criteria.data_tags->push_back(kDataTags[dice_.below(2)]);
    }
    if (dice_.once_in(2)) return criteria;
    criteria.partitions.emplace();
    // There are few expressions, so that every set of partitions can be tried.
    static constexpr const char* kPartitions[] = {"", "a", "*", "b*", "[ab]"};
    for (auto count = 1 + dice_.below(2); count > 0; --count) {
      criteria.partitions->push_back({kPartitions[dice_.below(5)]});
    }
    return criteria;
  }
  GrantRule rule() {
    GrantRule rule{.allow = !dice_.once_in(3)};
    const auto first = static_cast<DomainId>(dice_.below(kDomains));
    rule.domains.ranges = {{first, dice_.once_in(2) ? first : kDomains - 1}};
    if (!dice_.once_in(5)) rule.publish.push_back(criteria());
    if (dice_.once_in(3)) rule.publish.push_back(criteria());
    if (dice_.once_in(3)) rule.subscribe.push_back(criteria());
    if (dice_.once_in(5)) rule.relay.push_back(criteria());
    if (dice_.once_in(6)) rule.domains.tags.push_back({kTags[dice_.below(3)]});
    if (dice_.once_in(6)) rule.domains.tag_expressions.push_back({dice_.once_in(2) ? "*" : "?*"});
    return rule;
  }
  Validity validity() {
    const auto first = static_cast<int>(dice_.below(kTimes));
    return {at(first), at(first + static_cast<int>(dice_.below(kTimes)))};
  }
  Grant grant() {
    Grant grant{.subject_name = kSubjects[dice_.below(2)], .validity = {at(0), at(kTimes)}};
    if (dice_.once_in(4)) grant.validity = validity();
    for (auto rules = dice_.below(4); rules > 0; --rules) grant.rules.push_back(rule());
    grant.default_allow = dice_.once_in(6);
    return grant;
  }
  void edit(Grant& grant) {
    const auto kind = dice_.below(8);
    if (kind == 0) grant.validity = validity();
    if (kind == 1) grant.default_allow ^= true;
    if (kind == 2) grant.subject_name = kSubjects[dice_.below(2)];
    if (kind <= 2 || grant.rules.empty()) return grant.rules.push_back(rule());
    auto& rule_at = grant.rules[dice_.below(grant.rules.size())];
    if (kind == 3) rule_at = rule();
    if (kind == 4) std::swap(rule_at, grant.rules.front());
    if (kind == 5) rule_at.allow ^= true;
    if (kind == 6) grant.rules.insert(grant.rules.begin(), rule());
    if (kind == 7) grant.rules.erase(grant.rules.begin());
  }

  words::Dice dice_;
  bool with_partitions_;
};

// The model below is written from the rules of decision, without the code under test.

// One kind of partition: all words that are matched by the same expressions.
using Signature = std::vector<bool>;
using PartitionSet = std::vector<std::string>;

void collect(const std::vector<Criteria>& list, std::set<std::string>& texts) {
  for (const auto& criteria : list) {
    if (!criteria.partitions) continue;
    for (const auto& text : *criteria.partitions) texts.insert(text.text);
  }
}

// Returns every set of words in which no two are matched by the same expressions.
std::vector<PartitionSet> partition_sets(const Permissions& a, const Permissions& b) {
  std::set<std::string> texts = {""};
  for (const auto* document : {&a, &b}) {
    for (const auto& grant : document->grants) {
      for (const auto& rule : grant.rules) {
        collect(rule.publish, texts);
        collect(rule.subscribe, texts);
        collect(rule.relay, texts);
      }
    }
  }
  std::map<Signature, std::string> kinds;
  for (std::size_t i = 0; i < partitions().words().size(); ++i) {
    Signature signature;
    for (const auto& text : texts) signature.push_back(partitions().matches(text)[i]);
    kinds.try_emplace(signature, partitions().words()[i]);
  }
  std::vector<PartitionSet> sets;
  for (unsigned bits = 1; bits < 1u << kinds.size(); ++bits) {
    PartitionSet set;
    unsigned place = 0;
    for (const auto& [signature, word] : kinds) {
      if ((bits >> place++ & 1) != 0) set.push_back(word);
    }
    sets.push_back(std::move(set));
  }
  return sets;
}

bool lists(const Criteria& criteria, const std::string& partition) {
  if (!criteria.partitions) return partition.empty();
  return std::ranges::any_of(*criteria.partitions, [&](const Text& text) {
    return Pattern(text.text).matches(partition);
  });
}

// An endpoint without its topic.
struct Entity {
  PartitionSet partitions;
  std::vector<DataTag> tags;
};

bool fits(const GrantRule& rule, const Criteria& criteria, const Entity& entity) {
  const auto listed = [&](const std::string& partition) { return lists(criteria, partition); };
  const auto tag_listed = [&](const DataTag& tag) {
    return criteria.data_tags &&
           std::ranges::find(*criteria.data_tags, tag) != criteria.data_tags->end();
  };
  if (rule.allow)
    return std::ranges::all_of(entity.partitions, listed) &&
           std::ranges::all_of(entity.tags, tag_listed);
  return (!criteria.partitions || std::ranges::any_of(entity.partitions, listed)) &&
         (!criteria.data_tags || std::ranges::any_of(entity.tags, tag_listed));
}

// A domain and a tag.
struct Cell {
  DomainId domain;
  std::string tag;
};

bool is_in(const GrantRule& rule, const Cell& cell) {
  const bool in_range = std::ranges::any_of(rule.domains.ranges, [&](const DomainRange& range) {
    return range.first <= cell.domain && cell.domain <= range.last;
  });
  const auto& [ranges, tags, expressions, line] = rule.domains;
  if (tags.empty() && expressions.empty()) return in_range && cell.tag.empty();
  const auto is = [&](const Text& text) { return text.text == cell.tag; };
  const auto fits = [&](const Text& text) { return Pattern(text.text).matches(cell.tag); };
  return in_range && (std::ranges::any_of(tags, is) || std::ranges::any_of(expressions, fits));
}

using Words = std::bitset<364>;  // a bit for each word of topics()

const Words& matching(const std::string& expression) {
  static std::map<std::string, Words> known;
  const auto [at, is_new] = known.try_emplace(expression);
  if (is_new) {
    const auto& matches = topics().matches(expression);
    for (std::size_t i = 0; i < matches.size(); ++i) at->second[i] = matches[i];
  }
  return at->second;
}

Words allowed(const Grant& grant, const Cell& cell, std::vector<Criteria> GrantRule::*list,
              const Entity& entity) {
  Words result, decided;
  for (const auto& rule : grant.rules) {
    if (!is_in(rule, cell)) continue;
    for (const auto& criteria : rule.*list) {
      if (!fits(rule, criteria, entity)) continue;
      for (const auto& topic : criteria.topics) {
        const Words& matches = matching(topic.text);
        if (rule.allow) result |= matches & ~decided;
        decided |= matches;
      }
    }
  }
  // Only a relay element allows relays.
  if (grant.default_allow && list != &GrantRule::relay) result |= ~decided;
  return result;
}

bool may_join(const Grant& grant, const Cell& cell) {
  for (const auto& rule : grant.rules) {
    if (!is_in(rule, cell)) continue;
    if (rule.allow) return true;
    if (rule.publish.empty() && rule.subscribe.empty()) return false;
  }
  return grant.default_allow;
}

const Grant* first_valid(const Permissions& document, const std::string& subject, int time) {
  for (const auto& grant : document.grants) {
    if (grant.subject_name == subject && grant.validity.contains(at(time))) return &grant;
  }
  return nullptr;
}

struct Moves {
  bool wider = false, narrower = false;
  void add(bool before, bool after) {
    wider = wider || (!before && after);
    narrower = narrower || (before && !after);
  }
  void add(const Words& before, const Words& after) {
    wider = wider || (~before & after).any();
    narrower = narrower || (before & ~after).any();
  }
  ChangeClass verdict() const {
    if (wider && narrower) return ChangeClass::mixed;
    return wider ? ChangeClass::wider : narrower ? ChangeClass::narrower : ChangeClass::neutral;
  }
};

std::vector<Entity> entities(const Permissions& before, const Permissions& after) {
  std::vector<Entity> all;
  for (const auto& set : partition_sets(before, after))
    for (unsigned bits = 0; bits < 8; ++bits) {
      all.push_back({set, {}});
      for (unsigned i = 0; i < 3; ++i)
        if ((bits >> i & 1) != 0) all.back().tags.push_back(kDataTags[i]);
    }
  return all;
}

Moves reference(const Permissions& before, const Permissions& after) {
  static const Grant kNothing;
  const auto all = entities(before, after);
  Moves moves;
  std::set<std::pair<const Grant*, const Grant*>> seen;
  for (const std::string subject : kSubjects) {
    for (int time = 0; time < 2 * kTimes; ++time) {
      const auto* o = first_valid(before, subject, time);
      const auto* n = first_valid(after, subject, time);
      if ((!o && !n) || !seen.emplace(o, n).second) continue;
      moves.add(o != nullptr, n != nullptr);
      const Grant &old_grant = o ? *o : kNothing, &new_grant = n ? *n : kNothing;
      for (const DomainId domain : {0, 1, 9}) {
        for (const char* tag : kTags) {
          const Cell cell{domain, tag};
          moves.add(may_join(old_grant, cell), may_join(new_grant, cell));
          for (const auto& entity : all)
            for (auto list : {&GrantRule::publish, &GrantRule::subscribe, &GrantRule::relay})
              moves.add(allowed(old_grant, cell, list, entity),
                        allowed(new_grant, cell, list, entity));
        }
      }
    }
  }
  return moves;
}

bool judged(const Permissions& document, const PermissionChange& change) {
  const auto shared = std::make_shared<const Permissions>(document);
  const auto action = change.operation == "publish"     ? Action::publish
                      : change.operation == "subscribe" ? Action::subscribe
                                                        : Action::relay;
  const auto& partitions = change.entities.example_partitions;
  const std::vector<std::string_view> names(partitions.begin(), partitions.end());
  for (const auto& grant : shared->grants) {
    if (grant.subject_name != change.subject) continue;
    const auto& scope = change.scope;
    const CompiledGrant compiled(shared, grant, scope.domains.at(0).first, PartitionMatch::all,
                                 scope.tags.examples.at(0));
    const auto verdict = compiled.judge(action, {.topic = change.witness,
                                                 .partitions = names,
                                                 .data_tags = change.entities.example_data_tags});
    // The default does not apply to relays.
    return verdict.allowed && (action != Action::relay || verdict.rule != nullptr);
  }
  return false;
}

// Expects that the plugins decide about the witness as the change says. Only for documents with one
// grant for each subject.
void check_witnesses(const PermissionsDiff& diff, const Permissions& before,
                     const Permissions& after) {
  for (const auto& change : diff.changes) {
    if (change.element != "rule") continue;
    ASSERT_EQ(judged(before, change), change.old_value == "allowed") << change.witness;
    ASSERT_EQ(judged(after, change), change.new_value == "allowed") << change.witness;
  }
}

bool has_one_grant_a_subject(const Permissions& document) {
  std::set<std::string> subjects;
  return std::ranges::all_of(document.grants, [&](const Grant& grant) {
    return subjects.insert(grant.subject_name).second;
  });
}

void expect_agreement_of_pairs(std::uint32_t seed, int pairs, bool with_partitions) {
  ASSERT_EQ(topics().words().size(), Words().size());
  Author author(seed, with_partitions);
  std::map<ChangeClass, int> seen;
  for (int round = 0; round < pairs; ++round) {
    const auto before = author.document();
    const auto after = round % 4 == 0 ? author.document() : author.edited(before);
    const auto diff = compare(before, after);
    ASSERT_EQ(diff.verdict, reference(before, after).verdict()) << "round " << round;
    ASSERT_TRUE(diff.is_exact && diff.is_complete);
    if (has_one_grant_a_subject(before) && has_one_grant_a_subject(after)) {
      check_witnesses(diff, before, after);
    }
    // With few states, other ways to an answer are taken. They may give up, but must not give a
    // wrong answer.
    PermissionsDiffOptions options;
    options.limits.states = 8;
    const auto other = round % 8 == 1 ? compare(before, after, options).verdict : diff.verdict;
    ASSERT_TRUE(other == diff.verdict || other == ChangeClass::unknown) << "round " << round;
    ++seen[diff.verdict];
  }
  for (const auto verdict :
       {ChangeClass::neutral, ChangeClass::wider, ChangeClass::narrower, ChangeClass::mixed}) {
    EXPECT_GT(seen[verdict], pairs / 100);
  }
}

class PermissionsReference : public ::testing::TestWithParam<std::uint32_t> {};

TEST_P(PermissionsReference, TwoThousandPairs_AgreeWithTheModel) {
  expect_agreement_of_pairs(GetParam(), 2'000, false);
}
TEST_P(PermissionsReference, PairsWithPartitionsAndTags_AgreeWithTheModel) {
  expect_agreement_of_pairs(GetParam(), 300, true);
}

INSTANTIATE_TEST_SUITE_P(Seeds, PermissionsReference, ::testing::Range(1u, 3u));
INSTANTIATE_TEST_SUITE_P(MoreSeeds, PermissionsReference, ::testing::Range(3u, 6u));  // --long

}  // namespace
}  // namespace ddssec::governance
