// Finds the pairs of an old and a new rule that decide for the same names.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "governance/pattern_set.hpp"
#include "governance/topic_sets.hpp"

namespace ddssec::governance {

/// A list of rules; the first one that matches a name decides.
struct RuleList {
  struct Item {
    std::string_view expression;
    std::uint32_t rule;    ///< its number; ascending
    std::uint32_t effect;  ///< equal for rules that do the same
  };
  std::vector<Item> items = {};
  /// The effect for names that no rule matches.
  std::uint32_t default_effect = 0;
};

/// Finds the rule that decides for a name, one name at a time.
class RuleFinder {
 public:
  using Rule = std::optional<std::uint32_t>;

  explicit RuleFinder(const RuleList& rules);
  Rule first(std::string_view name) const;
  /// As first(name), with at most `steps` steps, which are subtracted; empty if they do not
  /// suffice.
  std::optional<Rule> first(std::string_view name, std::size_t& steps) const;

 private:
  PatternSet expressions_;
  std::vector<std::uint32_t> rule_of_;  ///< the rule of each expression
};

/// Names for which these two rules decide. An empty number means that no rule matches.
struct TopicPair {
  std::optional<std::uint32_t> old_rule, new_rule;
  std::string witness;
};

/// The pairs of an old and a new rule that decide for the same topic.
struct TopicPairs {
  std::vector<TopicPair> pairs = {};
  /// True if every pair of rules that decides for some name is included.
  bool names_all_rules = true;
  /// True if every pair of effects that some name has is included. False if a limit was reached.
  bool names_all_effects = true;
};

/// Returns all pairs of rules that decide for some name, as far as they are found within the
/// limits.
TopicPairs topic_pairs(const RuleList& old_list, const RuleList& new_list, const SetLimits& limits);

/// Names for which `pair` decides in the two lists, and `old_preceding` and `new_preceding` in the
/// lists that come before them.
struct PrecededPair {
  TopicPair pair;
  std::optional<std::uint32_t> old_preceding, new_preceding;
};

/// A list of rules and the list that comes before it.
struct PrecededList {
  const RuleList& rules;
  const RuleList& preceding;
};

/// Returns all combinations of the rules that decide for some name. Empty if a limit was reached.
std::optional<std::vector<PrecededPair>> preceded_pairs(const PrecededList& old_list,
                                                        const PrecededList& new_list,
                                                        const SetLimits& limits);

/// Returns the pairs for these names, with the first name of each as witness. `names_all_effects`
/// is false if not every name was looked up.
TopicPairs pairs_of_names(const std::vector<std::string>& names, const RuleList& old_list,
                          const RuleList& new_list, const SetLimits& limits);

}  // namespace ddssec::governance
