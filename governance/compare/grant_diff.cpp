#include "governance/compare/grant_diff.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <tuple>

#include "governance/compare/operation_diff.hpp"
#include "governance/decision.hpp"

namespace ddssec::governance {
namespace {

// The rules of both grants that apply in a region, by their numbers.
using RuleNumbers = std::vector<std::uint32_t>;
using RegionRules = std::pair<RuleNumbers, RuleNumbers>;

constexpr std::array<Operation, 3> kOperations = {{{"publish", &GrantRule::publish, true},
                                                   {"subscribe", &GrantRule::subscribe, true},
                                                   {"relay", &GrantRule::relay, false}}};

RuleNumbers rules_for(const Grant& grant, DomainId domain, std::string_view tag) {
  RuleNumbers numbers;
  for (std::uint32_t i = 0; i < grant.rules.size(); ++i)
    if (grant.rules[i].domains.contains(domain, tag)) numbers.push_back(i);
  return numbers;
}

RulePointers pointers(const Grant& grant, const RuleNumbers& numbers) {
  RulePointers rules;
  for (const auto number : numbers) rules.push_back(&grant.rules[number]);
  return rules;
}

// Decides whether a participant may join, as CompiledGrant::judge_participant does, and returns the
// deciding rule too.
std::pair<bool, const GrantRule*> may_join(const Grant& grant, const RulePointers& rules) {
  for (const GrantRule* rule : rules)
    if (decides_joining(*rule)) return {rule->allow, rule};
  return {grant.default_allow, nullptr};
}

void append(std::string& text, const std::vector<std::string>& list) {
  // No name holds NUL.
  for (const auto& one : list) text.append(one).push_back('\0');
  text += '\1';
}

void append(std::string& text, const NameSet& set) {
  text += static_cast<char>('0' + static_cast<int>(set.form));
  append(text, set.expressions);
  append(text, set.examples);
}

// A text that is different for different sets of topics, endpoints and tags.
std::string words_of(const PermissionChange& change, const DomainScope& scope) {
  std::string text;
  append(text, change.expressions_old);
  append(text, change.expressions_new);
  for (const auto& words : change.topics.words) {
    append(text, {words.expression, words.also});
    append(text, words.except);
  }
  text += change.entities.every ? 'e' : ' ';
  if (change.entities.partitions) append(text, *change.entities.partitions);
  append(text, change.entities.example_partitions);
  for (const auto& tag : change.entities.example_data_tags) append(text, {tag.name, tag.value});
  append(text, scope.tags);
  return text;
}

std::string_view default_word(bool allow) { return allow ? "ALLOW" : "DENY"; }

class GrantComparison {
 public:
  GrantComparison(const Grant& old_grant, const Grant& new_grant, const SetLimits& limits,
                  bool first_rule_creates_topic)
      : old_(old_grant),
        new_(new_grant),
        limits_(limits),
        first_rule_creates_topic_(first_rule_creates_topic) {}

  GrantDiff run() {
    std::vector<const DomainSet*> sets;
    for (const Grant* grant : {&old_, &new_})
      for (const auto& rule : grant->rules) sets.push_back(&rule.domains);
    if (const auto space = DomainSpace::of(sets)) {
      const auto regions = space->regions([&](DomainId id, const std::string& tag) {
        return RegionRules(rules_for(old_, id, tag), rules_for(new_, id, tag));
      });
      for (const auto& region : regions) compare_in(region);
    } else {
      add_change({}, unknown_change({}));
    }
    compare_defaults();
    for (const auto& change : diff_.changes) diff_.direction.add(change.change);
    if (!diff_.is_exact) diff_.direction.add(ChangeClass::unknown);
    for (auto& change : diff_.changes)
      change.scope.domains = joined(std::move(change.scope.domains));
    return std::move(diff_);
  }

 private:
  // All values of a change except its domains.
  using ChangeKey = std::tuple<std::string_view, std::string_view, ChangeClass, std::string, int,
                               int, std::string>;

  void compare_in(const DomainRegion<RegionRules>& region) {
    const auto old_rules = pointers(old_, region.answer.first);
    const auto new_rules = pointers(new_, region.answer.second);
    compare_joining(region.scope, old_rules, new_rules);
    for (const auto& operation : kOperations) {
      auto found = compare_operation({old_, new_, old_rules, new_rules, first_rule_creates_topic_},
                                     operation, limits_);
      by_default_.add(found.by_default);
      diff_.is_complete = diff_.is_complete && found.is_complete;
      diff_.is_exact = diff_.is_exact && found.is_exact;
      for (auto& change : found.changes) add_change(region.scope, std::move(change));
      if (found.is_known) continue;
      add_change(region.scope, unknown_change(operation.name));
      limits_.states = std::min<std::size_t>(limits_.states, 2'000);
    }
  }

  void compare_joining(const DomainScope& scope, const RulePointers& old_rules,
                       const RulePointers& new_rules) {
    const auto [before, old_rule] = may_join(old_, old_rules);
    const auto [after, new_rule] = may_join(new_, new_rules);
    if (before == after) return;
    const auto change = class_of(after);
    if (old_rules.empty() && new_rules.empty()) return by_default_.add(change);
    add_change(scope, {.element = "join",
                       .change = change,
                       .old_value = std::string(verdict_word(before)),
                       .new_value = std::string(verdict_word(after)),
                       .old_line = old_rule ? old_rule->line : old_.line,
                       .new_line = new_rule ? new_rule->line : new_.line});
  }

  PermissionChange unknown_change(std::string_view operation) const {
    return {.element = "rule",
            .operation = operation,
            .change = ChangeClass::unknown,
            .old_line = old_.line,
            .new_line = new_.line};
  }

  // Reports the same change in several domains with the same tags once.
  void add_change(const DomainScope& scope, PermissionChange change) {
    const ChangeKey key(change.element, change.operation, change.change, change.witness,
                        change.old_line, change.new_line, words_of(change, scope));
    const auto [entry, is_new] = index_of_change_.try_emplace(key, diff_.changes.size());
    if (is_new) {
      change.scope = scope;
      diff_.changes.push_back(std::move(change));
      return;
    }
    auto& domains = diff_.changes[entry->second].scope.domains;
    domains.insert(domains.end(), scope.domains.begin(), scope.domains.end());
  }

  void compare_defaults() {
    if (old_.default_allow == new_.default_allow) return;
    const auto change = by_default_.change_class(ChangeClass::narrower, ChangeClass::wider);
    diff_.changes.insert(diff_.changes.begin(),
                         {.element = "default",
                          .change = change,
                          .old_value = std::string(default_word(old_.default_allow)),
                          .new_value = std::string(default_word(new_.default_allow)),
                          .old_line = old_.line,
                          .new_line = new_.line});
  }

  const Grant& old_;
  const Grant& new_;
  SetLimits limits_;
  bool first_rule_creates_topic_;
  GrantDiff diff_;
  CombinedChange by_default_;
  std::map<ChangeKey, std::size_t> index_of_change_;  // indices into diff_.changes
};

}  // namespace

GrantDiff compare_grants(const Grant& old_grant, const Grant& new_grant, const SetLimits& limits,
                         bool first_rule_creates_topic) {
  return GrantComparison(old_grant, new_grant, limits, first_rule_creates_topic).run();
}

}  // namespace ddssec::governance
