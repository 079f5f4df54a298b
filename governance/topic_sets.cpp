#include "governance/topic_sets.hpp"

#include <algorithm>

#include "governance/name_automaton.hpp"

namespace ddssec::governance {
namespace {

// Makes two sets into lists 0 and 1, in which every match counts alike.
std::vector<RankedExpression> two_sets(std::span<const std::string_view> first,
                                       std::span<const std::string_view> second) {
  std::vector<RankedExpression> both;
  both.reserve(first.size() + second.size());
  for (const auto expression : first) both.push_back({expression, 0, 0});
  for (const auto expression : second) both.push_back({expression, 1, 0});
  return both;
}

// Laying out the expressions takes time and memory for each octet before the first step is
// counted. False if there is not enough left.
bool pay_for_layout(std::span<const RankedExpression> expressions, const SetLimits& limits) {
  constexpr std::size_t kStepsForOctet = 8, kMemoryForOctet = 4;
  std::size_t octets = 0;
  for (const auto& item : expressions) octets += item.expression.size() + 1;
  if (octets > limits.memory / kMemoryForOctet) return false;
  if (limits.shared == nullptr) return true;
  auto& left = limits.shared->steps;
  const bool is_enough = octets <= left / kStepsForOctet;
  left = is_enough ? left - octets * kStepsForOctet : 0;
  return is_enough;
}

SetAnswer search(std::span<const RankedExpression> sets, const SetLimits& limits,
                 NameAutomaton::Goal goal, SetAnswer::Kind if_met, SetAnswer::Kind if_not) {
  if (!pay_for_layout(sets, limits)) return {};
  NameAutomaton automaton(sets, limits, std::move(goal));
  switch (automaton.run()) {
    case NameAutomaton::End::goal_reached:
      return {if_met, automaton.goal_name()};
    case NameAutomaton::End::complete:
      return {if_not, {}};
    case NameAutomaton::End::limit_reached:
      break;
  }
  return {};
}

}  // namespace

std::optional<std::uint32_t> NameAtom::rank_in(std::uint32_t list) const {
  const auto match = std::ranges::lower_bound(matches, list, {}, &Match::list);
  if (match == matches.end() || match->list != list) return std::nullopt;
  return match->rank;
}

FoundAtoms find_name_atoms(std::span<const RankedExpression> expressions, const SetLimits& limits) {
  if (!pay_for_layout(expressions, limits)) return {{}, false};
  NameAutomaton automaton(expressions, limits, {});
  const bool is_complete = automaton.run() == NameAutomaton::End::complete;
  return {automaton.atoms(), is_complete};
}

std::optional<std::vector<NameAtom>> name_atoms(std::span<const RankedExpression> expressions,
                                                const SetLimits& limits) {
  auto found = find_name_atoms(expressions, limits);
  if (!found.is_complete) return std::nullopt;
  return std::move(found.atoms);
}

SetAnswer contained(std::span<const std::string_view> inner,
                    std::span<const std::string_view> outer, const SetLimits& limits) {
  return search(two_sets(inner, outer), limits, {{0}, {1}}, SetAnswer::Kind::no,
                SetAnswer::Kind::yes);
}

SetAnswer overlap(std::span<const std::string_view> a, std::span<const std::string_view> b,
                  const SetLimits& limits) {
  return search(two_sets(a, b), limits, {{0, 1}, {}}, SetAnswer::Kind::yes, SetAnswer::Kind::no);
}

}  // namespace ddssec::governance
