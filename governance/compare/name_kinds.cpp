#include "governance/compare/name_kinds.hpp"

#include <algorithm>

namespace ddssec::governance {

std::optional<NameKinds> NameKinds::of(std::vector<std::string> expressions,
                                       const SetLimits& limits) {
  NameKinds out;
  out.expressions_ = std::move(expressions);
  out.expressions_.emplace_back();
  std::ranges::sort(out.expressions_);
  const auto repeated = std::ranges::unique(out.expressions_);
  out.expressions_.erase(repeated.begin(), repeated.end());
  std::vector<RankedExpression> each;
  for (const auto& text : out.expressions_)
    each.push_back({text, static_cast<std::uint32_t>(each.size()), 0});
  auto atoms = name_atoms(each, limits);
  if (!atoms) return std::nullopt;
  // The empty name is the only one that "" matches.
  const auto empty_name = std::ranges::find_if(
      *atoms, [](const NameAtom& atom) { return atom.rank_in(0).has_value(); });
  std::rotate(atoms->begin(), empty_name, empty_name + 1);
  for (auto& atom : *atoms) {
    std::vector<bool> matched(out.expressions_.size());
    for (const auto& match : atom.matches) matched[match.list] = true;
    out.examples_.push_back(std::move(atom.witness));
    out.matched_.push_back(std::move(matched));
  }
  return out;
}

std::size_t NameKinds::number_of(std::string_view expression) const {
  return static_cast<std::size_t>(std::ranges::lower_bound(expressions_, expression) -
                                  expressions_.begin());
}

// Expressions that together match exactly the wanted kinds; when each was chosen, it was needed.
std::optional<std::vector<std::string>> NameKinds::covered_by(
    const std::vector<bool>& wanted) const {
  std::vector<bool> left = wanted;
  std::vector<std::string> out;
  const auto within = [&](std::size_t e) {
    for (std::size_t k = 0; k < size(); ++k)
      if (matched_[k][e] && !wanted[k]) return false;
    return true;
  };
  for (;;) {
    std::size_t best = 0, most = 0;
    for (std::size_t e = 0; e < expressions_.size(); ++e) {
      std::size_t count = 0;
      for (std::size_t k = 0; k < size(); ++k) count += left[k] && matched_[k][e];
      if (count > most && within(e)) best = e, most = count;
    }
    if (most == 0) break;
    out.push_back(expressions_[best]);
    for (std::size_t k = 0; k < size(); ++k)
      if (matched_[k][best]) left[k] = false;
  }
  if (std::ranges::find(left, true) != left.end()) return std::nullopt;
  return out;
}

NameSet NameKinds::describe(std::span<const Kind> kinds) const {
  NameSet out;
  std::vector<bool> wanted(size());
  for (const Kind kind : kinds) {
    wanted[kind] = true;
    out.examples.push_back(examples_[kind]);
  }
  if (kinds.size() == size()) return out;
  auto others = wanted;
  others.flip();
  auto listed = covered_by(wanted);
  auto except = covered_by(others);
  if (listed && (!except || listed->size() <= except->size())) {
    out.form = NameSet::Form::listed;
    out.expressions = *std::move(listed);
  } else if (except) {
    out.form = NameSet::Form::every_but;
    out.expressions = *std::move(except);
  } else {
    out.form = NameSet::Form::some;
  }
  return out;
}

}  // namespace ddssec::governance
