#include "governance/compare/domain_space.hpp"

#include "governance/expression_text.hpp"

namespace ddssec::governance {
namespace {

// The largest number of tags and tag expressions that are compared.
constexpr std::size_t kMaxTags = 64;

}  // namespace

std::optional<DomainSpace> DomainSpace::of(const std::vector<const DomainSet*>& sets) {
  std::vector<std::string> expressions;
  DomainCuts cuts;
  for (const auto* set : sets) {
    cuts.add(*set);
    for (const auto& tag : set->tags) expressions.push_back(expression_of(tag.text));
    for (const auto& tag : set->tag_expressions) expressions.push_back(tag.text);
  }
  std::ranges::sort(expressions);
  const auto repeated = std::ranges::unique(expressions);
  expressions.erase(repeated.begin(), repeated.end());
  if (expressions.size() > kMaxTags) return std::nullopt;
  const bool has_tags = std::ranges::any_of(expressions, [](const auto& e) { return !e.empty(); });
  auto tags = NameKinds::of(std::move(expressions), {.states = 20'000, .atoms = 4 * kMaxTags});
  if (!tags) return std::nullopt;
  DomainSpace out(*std::move(tags));
  out.cuts_ = cuts;
  out.has_tags_ = has_tags;
  return out;
}

}  // namespace ddssec::governance
