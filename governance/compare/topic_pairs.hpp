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
  explicit RuleFinder(const RuleList& rules);
  std::optional<std::uint32_t> first(std::string_view name) const;

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
  std::vector<TopicPair> pairs;
  /// False: too many to list; then there is a pair for every two effects that meet, but not for
  /// every two rules.
  bool complete = true;
};

/// Every pair that some name has. Nothing if a limit was reached.
std::optional<TopicPairs> topic_pairs(const RuleList& old_list, const RuleList& new_list,
                                      const SetLimits& limits);

}  // namespace ddssec::governance
