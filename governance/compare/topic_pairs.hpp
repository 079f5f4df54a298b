// Which rule of an old list and which rule of a new one decide for the same names.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "governance/matcher.hpp"
#include "governance/topic_sets.hpp"

namespace ddssec::governance {

/// A list of rules of which the first that matches a name decides.
struct RuleList {
  struct Item {
    std::string_view expression;
    std::uint32_t rule;    ///< its number; ascending
    std::uint32_t effect;  ///< equal for rules that do the same
  };
  std::vector<Item> items = {};
  /// What happens to names that no rule matches.
  std::uint32_t default_effect = 0;
};

/// Finds the rule that decides for a name, one name at a time.
class RuleFinder {
 public:
  using Rule = std::optional<std::uint32_t>;

  explicit RuleFinder(const RuleList& rules);
  Rule first(std::string_view name) const;
  /// The same within so many steps, which are taken off; nothing if they are too few.
  std::optional<Rule> first(std::string_view name, std::size_t& steps) const;

 private:
  PatternSet expressions_;
  std::vector<std::uint32_t> rule_of_;  ///< of each expression
};

/// Names that an old and a new list leave to these rules; nothing: no rule matches.
struct TopicPair {
  std::optional<std::uint32_t> old_rule, new_rule;
  std::string witness;
};

struct TopicPairs {
  std::vector<TopicPair> pairs = {};
  /// True: every two rules that decide for some name are there.
  bool names_all_rules = true;
  /// True: every two effects that some name has are there. False: a limit was reached.
  bool names_all_effects = true;
};

/// Every pair that some name has, as far as it can be found out within the limits.
TopicPairs topic_pairs(const RuleList& old_list, const RuleList& new_list, const SetLimits& limits);

/// The pairs of these names, the first name of each; `names_all_effects` is false if not every name
/// was looked up.
TopicPairs pairs_of_names(const std::vector<std::string>& names, const RuleList& old_list,
                          const RuleList& new_list, const SetLimits& limits);

}  // namespace ddssec::governance
