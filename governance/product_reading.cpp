#include "governance/product_reading.hpp"

#include <algorithm>
#include <iterator>
#include <set>
#include <string>
#include <utility>

#include "governance/dialect.hpp"
#include "governance/domain_cuts.hpp"
#include "governance/expression_text.hpp"

namespace ddssec::governance {
namespace {

// Returns true if a range was open.
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

// Returns true if the product reads the expression in its own way.
bool change_expression(std::string& expression, bool& is_padded, StockProduct product) {
  const bool is_cyclone = product == StockProduct::cyclonedds;
  std::string read = expression;
  if (!is_cyclone && std::exchange(is_padded, false))
    read = std::string(kMatchesNothing);
  else if (!is_portable(expression))
    read = is_cyclone ? meaning_in_cyclonedds(expression) : meaning_in_fastdds(expression);
  return std::exchange(expression, read) != read;
}

bool change_expressions(std::vector<Criteria>& list, StockProduct product) {
  bool any = false;
  const auto change = [&](Text& text) {
    if (change_expression(text.text, text.is_padded, product)) any = true;
  };
  for (auto& criteria : list) {
    std::ranges::for_each(criteria.topics, change);
    if (criteria.partitions) std::ranges::for_each(*criteria.partitions, change);
  }
  return any;
}

bool change_expressions(DomainRule& rule, StockProduct product) {
  bool any = false;
  for (auto& topic : rule.topic_rules)
    if (change_expression(topic.topic_expression, topic.is_padded, product)) any = true;
  return any;
}

bool change_expressions(GrantRule& rule, StockProduct product) {
  const bool any = change_expressions(rule.publish, product);
  return change_expressions(rule.subscribe, product) || any;
}

bool change_criteria(Criteria& criteria, StockProduct product) {
  if (product == StockProduct::fastdds)
    return std::exchange(criteria.partitions, std::nullopt).has_value();
  if (criteria.partitions) return false;
  criteria.partitions = {Text{.text = "", .line = criteria.line}};
  return true;
}

std::vector<Text> partitions_of(const Criteria& criteria) {
  return criteria.partitions.value_or(std::vector<Text>{{.text = "", .line = criteria.line}});
}

using Names = std::set<std::string, std::less<>>;

void add_partitions(Names& out, const std::vector<Criteria>& list) {
  for (const auto& criteria : list)
    for (const auto& text : partitions_of(criteria)) out.insert(text.text);
}

// Fast DDS searches for an endpoint's partitions in all elements of the rule, as if these were one
// element.
bool join_elements(std::vector<Criteria>& list) {
  Names all;
  add_partitions(all, list);
  const bool is_one = std::ranges::all_of(list, [&](const Criteria& criteria) {
    Names own;
    add_partitions(own, {criteria});
    return own.size() == all.size();
  });
  if (is_one) return false;
  Criteria joined{.partitions = std::vector<Text>(), .line = list.front().line};
  for (const auto& name : all) joined.partitions->push_back({.text = name, .line = joined.line});
  for (auto& criteria : list) {
    std::ranges::move(criteria.topics, std::back_inserter(joined.topics));
    if (!criteria.data_tags) continue;
    if (!joined.data_tags) joined.data_tags.emplace();
    std::ranges::move(*criteria.data_tags, std::back_inserter(*joined.data_tags));
  }
  list = {std::move(joined)};
  return true;
}

bool join_elements(GrantRule& rule) {
  const bool any = join_elements(rule.publish);
  return join_elements(rule.subscribe) || any;
}

bool takes_all_partitions(const Criteria& criteria) {
  const auto partitions = partitions_of(criteria);
  return std::ranges::find(partitions, "*", &Text::text) != partitions.end();
}

// Elements that deny the topics of an allow_rule in the partitions that it does not list.
std::vector<Criteria> denied_besides(const std::vector<Criteria>& list) {
  std::vector<Criteria> out;
  for (const auto& criteria : list)
    if (!takes_all_partitions(criteria))
      out.push_back({.topics = criteria.topics, .line = criteria.line});
  return out;
}

// For each rule: true if it is an allow_rule and later rules list partitions that it does not.
std::vector<bool> is_followed_by_more(const std::vector<GrantRule>& rules,
                                      std::vector<Criteria> GrantRule::*list) {
  std::vector<bool> out(rules.size());
  Names later;
  for (std::size_t i = rules.size(); i-- > 0;) {
    if (!rules[i].allow) continue;
    Names own;
    add_partitions(own, rules[i].*list);
    const auto known =
        std::ranges::count_if(own, [&](const std::string& name) { return later.contains(name); });
    out[i] = !own.empty() && static_cast<std::size_t>(known) < later.size();
    later.merge(own);
  }
  return out;
}

// Fast DDS stops at an allow_rule with the topic, whether its partitions match or not.
bool end_at_first(std::vector<GrantRule>& rules) {
  const auto in_publish = is_followed_by_more(rules, &GrantRule::publish),
             in_subscribe = is_followed_by_more(rules, &GrantRule::subscribe);
  std::vector<GrantRule> out;
  for (std::size_t i = 0; i < rules.size(); ++i) {
    out.push_back(rules[i]);
    GrantRule denial{.domains = rules[i].domains, .line = rules[i].line};
    if (in_publish[i]) denial.publish = denied_besides(rules[i].publish);
    if (in_subscribe[i]) denial.subscribe = denied_besides(rules[i].subscribe);
    if (!denial.publish.empty() || !denial.subscribe.empty()) out.push_back(std::move(denial));
  }
  const bool any = out.size() != rules.size();
  rules = std::move(out);
  return any;
}

bool change_rule(GrantRule& rule, StockProduct product) {
  bool any = close_ranges(rule.domains);
  if (change_expressions(rule, product)) any = true;
  if (product == StockProduct::cyclonedds && !rule.domains.tags.empty() &&
      rule.domains.tag_expressions.empty()) {
    rule.domains.tags.clear();
    any = true;
  }
  if (rule.allow) return (product == StockProduct::fastdds && join_elements(rule)) || any;
  for (auto* list : {&rule.publish, &rule.subscribe})
    for (auto& criteria : *list)
      if (change_criteria(criteria, product)) any = true;
  return any;
}

using Ranges = std::vector<DomainRange>;

bool have_same_domains(const Grant& grant) {
  return std::ranges::all_of(grant.rules, [&](const GrantRule& rule) {
    return rule.domains.ranges == grant.rules.front().domains.ranges;
  });
}

void add_allowed_domains(Ranges& out, const Permissions& document) {
  for (const auto& grant : document.grants)
    for (const auto& rule : grant.rules)
      if (rule.allow) out.insert(out.end(), rule.domains.ranges.begin(), rule.domains.ranges.end());
}

void set_domains(Permissions& document, const Ranges& ranges) {
  for (auto& grant : document.grants)
    for (auto& rule : grant.rules) rule.domains.ranges = ranges;
}

}  // namespace

std::string_view to_string(StockProduct product) {
  return product == StockProduct::cyclonedds ? "Cyclone DDS" : "Fast DDS";
}

Validity rewritten_for(const Validity& validity, StockProduct product) {
  auto out = validity;
  if (product == StockProduct::cyclonedds) {
    if (!std::exchange(out.is_read_alike_by_cyclonedds, true)) out.not_after = out.not_before;
  } else {
    out.not_before += std::exchange(out.offset_of_not_before, {});
    out.not_after += std::exchange(out.offset_of_not_after, {});
  }
  return out;
}

std::optional<Governance> rewritten_for(const Governance& document, StockProduct product) {
  auto out = document;
  bool any = false;
  for (auto& rule : out.domain_rules) {
    if (close_ranges(rule.domains)) any = true;
    if (change_expressions(rule, product)) any = true;
  }
  return any ? std::optional(std::move(out)) : std::nullopt;
}

std::optional<Permissions> rewritten_for(const Permissions& document, StockProduct product) {
  auto out = document;
  bool any = false;
  for (auto& grant : out.grants) {
    const auto written = std::exchange(grant.validity, rewritten_for(grant.validity, product));
    if (grant.validity != written) any = true;
    for (auto& rule : grant.rules)
      if (change_rule(rule, product)) any = true;
    if (product != StockProduct::fastdds) continue;
    if (end_at_first(grant.rules)) any = true;
    if (std::exchange(grant.default_allow, false)) any = true;
  }
  return any ? std::optional(std::move(out)) : std::nullopt;
}

std::optional<PermissionsOfOwnEndpoints> rewritten_for_own_endpoints_of_fastdds(
    const Permissions& before, const Permissions& after) {
  PermissionsOfOwnEndpoints out{rewritten_for(before, StockProduct::fastdds).value_or(before),
                                rewritten_for(after, StockProduct::fastdds).value_or(after)};
  if (std::ranges::all_of(out.before.grants, have_same_domains) &&
      std::ranges::all_of(out.after.grants, have_same_domains))
    return std::nullopt;
  Ranges all;
  add_allowed_domains(all, out.before);
  add_allowed_domains(all, out.after);
  all = joined(std::move(all));
  set_domains(out.before, all);
  set_domains(out.after, all);
  return out;
}

std::optional<DomainRule> rewritten_expressions(const DomainRule& rule, StockProduct product) {
  auto out = rule;
  return change_expressions(out, product) ? std::optional(std::move(out)) : std::nullopt;
}

std::optional<Grant> rewritten_expressions(const Grant& grant, StockProduct product) {
  auto out = grant;
  bool any = false;
  for (auto& rule : out.rules)
    if (change_expressions(rule, product)) any = true;
  return any ? std::optional(std::move(out)) : std::nullopt;
}

}  // namespace ddssec::governance
