// An oracle for the expression of a list that matches a name first: the automaton over the whole
// list.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "governance/topic_sets.hpp"

namespace ddssec::governance {

/// Returns, for each expression of a list that is tried in order, a name for which it is the first
/// match, or empty if it can never be the first. Returns no result if a limit was reached.
inline std::optional<std::vector<std::optional<std::string>>> first_matched_names(
    std::span<const std::string_view> expressions) {
  std::vector<RankedExpression> ranked;
  for (const auto expression : expressions)
    ranked.push_back({expression, 0, static_cast<std::uint32_t>(ranked.size())});
  const auto atoms = name_atoms(ranked);
  if (!atoms) return std::nullopt;
  std::vector<std::optional<std::string>> names(expressions.size());
  for (const auto& atom : *atoms)
    if (const auto rank = atom.rank_in(0)) names[*rank] = atom.witness;
  return names;
}

}  // namespace ddssec::governance
