#include "governance/as_read.hpp"

#include <utility>

namespace ddssec::governance {
namespace {

// True if something was open.
bool close_ranges(DomainSet& domains) {
  bool any = false;
  for (auto& range : domains.ranges) {
    if (!range.is_open) continue;
    any = any || range.last != range.first;
    range.last = range.first;
    range.is_open = false;
  }
  return any;
}

bool change_criteria(Criteria& criteria, StockProduct product) {
  if (product == StockProduct::fastdds)
    return std::exchange(criteria.partitions, std::nullopt).has_value();
  if (criteria.partitions) return false;
  criteria.partitions = {Text{.text = "", .line = criteria.line}};
  return true;
}

bool change_rule(Rule& rule, StockProduct product) {
  bool any = close_ranges(rule.domains);
  if (product == StockProduct::cyclonedds && !rule.domains.tags.empty() &&
      rule.domains.tag_expressions.empty()) {
    rule.domains.tags.clear();
    any = true;
  }
  if (rule.allow) return any;
  for (auto* list : {&rule.publish, &rule.subscribe})
    for (auto& criteria : *list)
      if (change_criteria(criteria, product)) any = true;
  return any;
}

}  // namespace

std::string_view to_string(StockProduct product) {
  return product == StockProduct::cyclonedds ? "Cyclone DDS" : "Fast DDS";
}

std::optional<Governance> as_stock_reads(const Governance& document) {
  auto out = document;
  bool any = false;
  for (auto& rule : out.domain_rules)
    if (close_ranges(rule.domains)) any = true;
  return any ? std::optional(std::move(out)) : std::nullopt;
}

std::optional<Permissions> as_stock_reads(const Permissions& document, StockProduct product) {
  auto out = document;
  bool any = false;
  for (auto& grant : out.grants) {
    for (auto& rule : grant.rules)
      if (change_rule(rule, product)) any = true;
    if (product == StockProduct::fastdds && std::exchange(grant.default_allow, false)) any = true;
  }
  return any ? std::optional(std::move(out)) : std::nullopt;
}

}  // namespace ddssec::governance
