// An oracle for what matches first in a list: the automaton over the whole list.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "governance/topic_sets.hpp"

namespace ddssec::governance {

/// For each expression of a list that is tried in order: a name for which it is the first match, or
/// empty for an expression that can never be the first. No result if a limit was reached.
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
