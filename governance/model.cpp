#include "governance/model.hpp"

#include <algorithm>

#include "governance/pattern.hpp"

namespace ddssec::governance {

bool DomainSet::contains(DomainId id, std::string_view tag) const {
  const bool id_fits = std::ranges::any_of(
      ranges, [&](const DomainRange& range) { return range.first <= id && id <= range.last; });
  if (!id_fits) return false;
  if (tags.empty() && tag_expressions.empty()) return tag.empty();
  return std::ranges::any_of(tags, [&](const Text& t) { return t.text == tag; }) ||
         std::ranges::any_of(tag_expressions,
                             [&](const Text& t) { return Pattern(t.text).matches(tag); });
}

bool DomainSet::contains_for_stock(DomainId id) const {
  return std::ranges::any_of(ranges, [&](const DomainRange& range) {
    return range.first <= id && id <= (range.is_open ? range.first : range.last);
  });
}

const DomainRule* Governance::find(DomainId id, std::string_view tag) const {
  const auto rule = std::ranges::find_if(
      domain_rules, [&](const DomainRule& r) { return r.domains.contains(id, tag); });
  return rule == domain_rules.end() ? nullptr : &*rule;
}

const DomainRule* Governance::find_for_stock(DomainId id) const {
  const auto rule = std::ranges::find_if(
      domain_rules, [&](const DomainRule& r) { return r.domains.contains_for_stock(id); });
  return rule == domain_rules.end() ? nullptr : &*rule;
}

}  // namespace ddssec::governance
