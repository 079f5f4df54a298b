#include "governance/shadowed_expressions.hpp"

#include <algorithm>
#include <optional>
#include <string>

#include "governance/pattern.hpp"
#include "governance/pattern_set.hpp"

namespace ddssec::governance {
namespace {

constexpr SetLimits kLimits{.states = 20'000, .steps = 10'000'000};
// The largest number of rounds in which the list of suspects may grow. After these the expression
// counts as not shadowed.
constexpr int kMaxRounds = 16;
// The largest number of positions with the same text that are examined.
constexpr std::size_t kMaxTwins = 64;

// Returns a name that the expression matches; empty if none is easily found.
std::optional<std::string> sample(std::string_view expression) {
  const Pattern pattern(expression);
  if (pattern.is_literal()) return std::string(expression);
  std::string out;
  for (const auto& step : pattern.steps()) {
    if (step.kind == Pattern::Kind::set) return std::nullopt;
    if (step.kind == Pattern::Kind::character) out += static_cast<char>(step.character);
    if (step.kind == Pattern::Kind::any) out += 'a';
  }
  return out;
}

// The usual case needs no automaton: a later expression begins with the prefix of an earlier one
// that is a prefix and a star.
bool is_plainly_within(std::string_view inner, std::string_view outer) {
  if (inner == outer) return true;
  constexpr std::string_view kSpecial = "*?[\\";
  if (!outer.ends_with('*') || outer.find_first_of(kSpecial) != outer.size() - 1) return false;
  const auto beginning = outer.substr(0, outer.size() - 1);
  return inner.starts_with(beginning);
}

// The earlier expressions of a list, found by the names that they match.
class EarlierExpressions {
 public:
  using Covers = std::function<bool(std::uint32_t, std::uint32_t)>;

  EarlierExpressions(std::span<const std::string_view> expressions, SetEffort& effort,
                     const Covers& covers)
      : expressions_(expressions),
        effort_(effort),
        limits_(kLimits.sharing(effort)),
        covers_(covers) {
    for (std::uint32_t i = 0; i < expressions.size(); ++i) {
      const auto id = set_.add(expressions[i]);
      if (id == positions_.size()) positions_.emplace_back();
      positions_[id].push_back(i);
    }
    set_.seal();
  }

  ShadowedExpression shadow_of(std::uint32_t at) const {
    std::vector<std::uint32_t> suspects;
    const auto name = sample(expressions_[at]);
    // No earlier expression matches the name.
    if (name && !add_matching(*name, at, suspects)) return {};
    for (int round = 0; round < kMaxRounds; ++round) {
      const auto answer = within(at, suspects);
      if (answer.kind == SetAnswer::Kind::yes) return {true, fewest(at, suspects)};
      if (answer.kind == SetAnswer::Kind::unknown || !add_matching(answer.witness, at, suspects))
        return {};
    }
    return {};
  }

 private:
  // Adds the earlier expressions that match the name and cover `at`. True if some of them are new.
  bool add_matching(std::string_view name, std::uint32_t at,
                    std::vector<std::uint32_t>& suspects) const {
    std::vector<PatternSet::Id> ids;
    if (!set_.match(name, ids, effort_.plain_steps)) return false;
    const auto before = suspects.size();
    for (const auto id : ids)
      if (const auto found = covering(positions_[id], at))
        if (std::ranges::find(suspects, *found) == suspects.end()) suspects.push_back(*found);
    return suspects.size() > before;
  }

  std::optional<std::uint32_t> covering(const std::vector<std::uint32_t>& twins,
                                        std::uint32_t at) const {
    for (std::size_t i = 0; i < std::min(twins.size(), kMaxTwins) && twins[i] < at; ++i)
      if (!covers_ || covers_(twins[i], at)) return twins[i];
    return std::nullopt;
  }

  SetAnswer within(std::uint32_t at, const std::vector<std::uint32_t>& suspects) const {
    const std::string_view inner[] = {expressions_[at]};
    for (const auto suspect : suspects)
      if (is_plainly_within(inner[0], expressions_[suspect])) return {.kind = SetAnswer::Kind::yes};
    std::vector<std::string_view> outer;
    for (const auto suspect : suspects) outer.push_back(expressions_[suspect]);
    return contained(inner, outer, limits_);
  }

  // Returns a single suspect that suffices, if there is one; otherwise those that cannot be left
  // out.
  std::vector<std::uint32_t> fewest(std::uint32_t at, std::vector<std::uint32_t> all) const {
    std::ranges::sort(all);
    for (const auto one : all)
      if (within(at, {one}).kind == SetAnswer::Kind::yes) return {one};
    constexpr std::size_t kFewEnough = 16;
    for (std::size_t i = all.size() > kFewEnough ? 0 : all.size(); i-- > 0;) {
      auto without = all;
      without.erase(without.begin() + static_cast<std::ptrdiff_t>(i));
      if (within(at, without).kind == SetAnswer::Kind::yes) all = std::move(without);
    }
    return all;
  }

  std::span<const std::string_view> expressions_;
  SetEffort& effort_;
  SetLimits limits_;
  const Covers& covers_;
  PatternSet set_;
  std::vector<std::vector<std::uint32_t>> positions_;  // by the id of their text
};

}  // namespace

std::vector<ShadowedExpression> shadows(
    std::span<const std::string_view> expressions, SetEffort& effort,
    const std::function<bool(std::uint32_t, std::uint32_t)>& covers) {
  const EarlierExpressions earlier(expressions, effort, covers);
  std::vector<ShadowedExpression> out;
  out.reserve(expressions.size());
  for (std::uint32_t i = 0; i < expressions.size(); ++i) out.push_back(earlier.shadow_of(i));
  return out;
}

}  // namespace ddssec::governance
