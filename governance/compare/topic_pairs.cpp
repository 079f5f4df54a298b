#include "governance/compare/topic_pairs.hpp"

#include <algorithm>
#include <limits>
#include <set>

#include "governance/byte_classes.hpp"

namespace ddssec::governance {
namespace {

// The limits for examining each rule by itself. If the rules need more, those with the same effect
// are combined, with the effort that is left.
constexpr SetLimits kForEachRule = {.states = 50'000, .steps = 50'000'000, .memory = 12'000'000};
// The largest number of rules that are proved dead one at a time.
constexpr std::size_t kMaxProofs = 64;
constexpr SetLimits kForOneProof = {.states = 20'000, .steps = 5'000'000};

void add_each_rule(std::vector<RankedExpression>& to, const RuleList& rules, std::uint32_t list) {
  for (const auto& item : rules.items) to.push_back({item.expression, list, item.rule});
}

// Adjacent rules with the same effect get one rank. The last ones get none if their effect is that
// of the default.
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

SetLimits lower(const SetLimits& a, const SetLimits& b) {
  return {std::min(a.states, b.states), std::min(a.atoms, b.atoms), std::min(a.steps, b.steps),
          std::min(a.memory, b.memory), a.shared != nullptr ? a.shared : b.shared};
}

// A name that the expression matches, with `for_star` for every star; empty if there is none.
std::optional<std::string> example_of(const Pattern& pattern, std::string_view for_star) {
  if (pattern.is_literal()) return pattern.text();
  std::string name;
  for (const auto& step : pattern.steps()) {
    if (step.kind == Pattern::Kind::star) name += for_star;
    if (step.kind == Pattern::Kind::any) name += 'a';
    if (step.kind == Pattern::Kind::character) name += static_cast<char>(step.character);
    if (step.kind != Pattern::Kind::set) continue;
    const auto& set = pattern.set_of(step);
    const auto octet = std::ranges::find_if(
        octets_by_readability(), [&](char c) { return set.test(static_cast<std::uint8_t>(c)); });
    if (octet == octets_by_readability().end()) return std::nullopt;
    name += *octet;
  }
  // The empty name is the example only if there is no other name.
  return name.empty() ? "a" : name;
}

// Adds pairs, each once, with the rules that decide for a name.
class PairsByName {
 public:
  using Rule = RuleFinder::Rule;

  // If `effort` is nullptr, the number of steps is not limited.
  PairsByName(const RuleList& old_list, const RuleList& new_list, SetEffort* effort)
      : old_(old_list),
        new_(new_list),
        steps_(effort != nullptr ? effort->plain_steps : unbounded_) {}

  // Adds the pair for the name and returns the old rule that decides. If the steps have run out,
  // returns nothing and leaves the name out.
  Rule add(std::string name) {
    const auto o = is_complete_ ? old_.first(name, steps_) : std::nullopt;
    const auto n = o ? new_.first(name, steps_) : std::nullopt;
    is_complete_ = n.has_value();
    if (!is_complete_) return std::nullopt;
    if (known_.emplace(*o, *n).second) pairs_.push_back({*o, *n, std::move(name)});
    return *o;
  }
  void add_examples(const RuleList& list) {
    for (const auto& item : list.items) {
      const Pattern pattern(item.expression);
      for (const char* for_star : {"", "a"}) {
        if (!is_complete_) return;
        if (auto name = example_of(pattern, for_star)) add(std::move(*name));
      }
    }
  }
  std::vector<TopicPair> take() { return std::move(pairs_); }
  // False if names were left out because the steps ran out.
  bool is_complete() const { return is_complete_; }

 private:
  RuleFinder old_, new_;
  std::size_t unbounded_ = std::numeric_limits<std::size_t>::max();
  std::size_t& steps_;
  bool is_complete_ = true;
  std::set<std::pair<Rule, Rule>> known_;
  std::vector<TopicPair> pairs_;
};

bool same_expressions(const RuleList& a, const RuleList& b) {
  return std::ranges::equal(a.items, b.items, {}, &RuleList::Item::expression,
                            &RuleList::Item::expression);
}

// Finds the pairs of lists that differ in their effects only. The same rule decides in both, so the
// question is only which rules are alive. Empty if that is not found out quickly.
std::optional<TopicPairs> pairs_of_same_rules(const RuleList& old_list, const RuleList& new_list,
                                              const SetLimits& limits) {
  PairsByName pairs(old_list, new_list, limits.shared);
  const auto for_one_proof = lower(limits, kForOneProof);
  std::vector<std::size_t> unproved;
  for (std::size_t i = 0; i < old_list.items.size(); ++i) {
    const auto& item = old_list.items[i];
    auto name = example_of(Pattern(item.expression), "");
    if (name && pairs.add(std::move(*name)) != item.rule) unproved.push_back(i);
  }
  if (unproved.size() > kMaxProofs || !pairs.is_complete()) return std::nullopt;
  std::vector<std::string_view> earlier;
  for (const auto& item : old_list.items) earlier.push_back(item.expression);
  for (const auto i : unproved) {
    auto answer = contained({&earlier[i], 1}, {earlier.data(), i}, for_one_proof);
    if (answer.kind == SetAnswer::Kind::unknown) return std::nullopt;
    if (answer.kind == SetAnswer::Kind::no) pairs.add(std::move(answer.witness));
  }
  const std::string_view every[] = {"*"};
  auto uncovered = contained(every, earlier, for_one_proof);
  if (uncovered.kind == SetAnswer::Kind::unknown) return std::nullopt;
  if (uncovered.kind == SetAnswer::Kind::no) pairs.add(std::move(uncovered.witness));
  if (!pairs.is_complete()) return std::nullopt;
  return TopicPairs{pairs.take()};
}

}  // namespace

RuleFinder::RuleFinder(const RuleList& rules) {
  for (const auto& item : rules.items) {
    const auto id = expressions_.add(item.expression);
    if (id == rule_of_.size()) rule_of_.push_back(item.rule);
  }
  expressions_.seal();
}

RuleFinder::Rule RuleFinder::first(std::string_view name) const {
  auto unbounded = std::numeric_limits<std::size_t>::max();
  return first(name, unbounded).value_or(std::nullopt);
}

std::optional<RuleFinder::Rule> RuleFinder::first(std::string_view name, std::size_t& steps) const {
  std::vector<PatternSet::Id> found;
  if (!expressions_.match(name, found, steps)) return std::nullopt;
  return found.empty() ? Rule() : Rule(rule_of_[found.front()]);
}

TopicPairs topic_pairs(const RuleList& old_list, const RuleList& new_list,
                       const SetLimits& limits) {
  std::vector<RankedExpression> expressions;
  add_each_rule(expressions, old_list, 0);
  add_each_rule(expressions, new_list, 1);
  if (auto atoms = name_atoms(expressions, lower(limits, kForEachRule))) {
    TopicPairs result;
    for (auto& atom : *atoms) {
      result.pairs.push_back({atom.rank_in(0), atom.rank_in(1), std::move(atom.witness)});
    }
    return result;
  }
  if (same_expressions(old_list, new_list)) {
    if (auto pairs = pairs_of_same_rules(old_list, new_list, limits)) return std::move(*pairs);
  }
  expressions.clear();
  add_effects(expressions, old_list, 0);
  add_effects(expressions, new_list, 1);
  auto found = find_name_atoms(expressions, limits);
  // Examples for single rules show most of the pairs that the atoms do not list.
  PairsByName pairs(old_list, new_list, limits.shared);
  for (auto& atom : found.atoms) pairs.add(std::move(atom.witness));
  pairs.add_examples(old_list);
  pairs.add_examples(new_list);
  // If names were left out, pairs of effects may be missing.
  const bool names_all_effects = found.is_complete && pairs.is_complete();
  return {pairs.take(), false, names_all_effects};
}

std::optional<std::vector<PrecededPair>> preceded_pairs(const PrecededList& old_list,
                                                        const PrecededList& new_list,
                                                        const SetLimits& limits) {
  std::vector<RankedExpression> expressions;
  add_each_rule(expressions, old_list.rules, 0);
  add_each_rule(expressions, new_list.rules, 1);
  add_each_rule(expressions, old_list.preceding, 2);
  add_each_rule(expressions, new_list.preceding, 3);
  auto atoms = name_atoms(expressions, limits);
  if (!atoms) return std::nullopt;
  std::vector<PrecededPair> pairs;
  for (auto& atom : *atoms)
    pairs.push_back({{atom.rank_in(0), atom.rank_in(1), std::move(atom.witness)},
                     atom.rank_in(2),
                     atom.rank_in(3)});
  return pairs;
}

TopicPairs pairs_of_names(const std::vector<std::string>& names, const RuleList& old_list,
                          const RuleList& new_list, const SetLimits& limits) {
  PairsByName pairs(old_list, new_list, limits.shared);
  for (const auto& name : names) pairs.add(name);
  return {pairs.take(), true, pairs.is_complete()};
}

}  // namespace ddssec::governance
