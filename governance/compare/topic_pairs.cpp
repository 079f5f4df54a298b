#include "governance/compare/topic_pairs.hpp"

#include <algorithm>

namespace ddssec::governance {
namespace {

/// Where the rules one by one need more states than this, rules of equal effect are taken together
/// at once: a second attempt is what time is left for.
constexpr std::size_t kStatesForEachRule = 50'000;

void add_each_rule(std::vector<RankedExpression>& to, const RuleList& rules, std::uint32_t list) {
  for (const auto& item : rules.items) to.push_back({item.expression, list, item.rule});
}

/// Neighbours of equal effect get one rank, and the last ones, if they do what would be done
/// without them, none.
void add_effects(std::vector<RankedExpression>& to, const RuleList& rules, std::uint32_t list) {
  std::size_t count = rules.items.size();
  while (count > 0 && rules.items[count - 1].effect == rules.default_effect) --count;
  std::uint32_t rank = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const auto& item = rules.items[i];
    if (i > 0 && item.effect != rules.items[i - 1].effect) ++rank;
    to.push_back({item.expression, list, rank});
  }
}

}  // namespace

RuleFinder::RuleFinder(const RuleList& rules) {
  for (const auto& item : rules.items) {
    const auto id = expressions_.add(item.expression);
    if (id == rule_of_.size()) rule_of_.push_back(item.rule);
  }
  expressions_.seal();
}

std::optional<std::uint32_t> RuleFinder::first(std::string_view name) const {
  const auto id = expressions_.first_match(name);
  return id == PatternSet::kNone ? std::nullopt : std::optional(rule_of_[id]);
}

std::optional<TopicPairs> topic_pairs(const RuleList& old_list, const RuleList& new_list,
                                      const SetLimits& limits) {
  TopicPairs result;
  std::vector<RankedExpression> expressions;
  add_each_rule(expressions, old_list, 0);
  add_each_rule(expressions, new_list, 1);
  SetLimits first_limits = limits;
  first_limits.states = std::min(limits.states, kStatesForEachRule);
  if (auto atoms = name_atoms(expressions, first_limits)) {
    for (auto& atom : *atoms) {
      result.pairs.push_back({atom.rank_in(0), atom.rank_in(1), std::move(atom.witness)});
    }
    return result;
  }
  expressions.clear();
  add_effects(expressions, old_list, 0);
  add_effects(expressions, new_list, 1);
  auto atoms = name_atoms(expressions, limits);
  if (!atoms) return std::nullopt;
  result.complete = false;
  const RuleFinder old_rules(old_list), new_rules(new_list);
  for (auto& atom : *atoms) {
    result.pairs.push_back(
        {old_rules.first(atom.witness), new_rules.first(atom.witness), std::move(atom.witness)});
  }
  return result;
}

}  // namespace ddssec::governance
