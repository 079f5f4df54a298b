#include "governance/doctor/product_decision.hpp"

#include <algorithm>
#include <array>
#include <optional>

#include "governance/dialect.hpp"
#include "governance/product_reading.hpp"

namespace ddssec::governance::doctor {
namespace {

using Partitions = std::span<const std::string_view>;

bool reads_as_match(Product product, std::string_view expression, std::string_view name) {
  if (expression.find_first_of("*?[\\") == expression.npos) return expression == name;
  const bool is_plain = expression.find_first_of("[\\") == expression.npos;
  if (product == Product::ddssec || is_plain) return Pattern(expression).matches(name);
  return Pattern(product == Product::cyclonedds ? meaning_in_cyclonedds(expression)
                                                : meaning_in_fastdds(expression))
      .matches(name);
}

bool any_matches(Product product, const std::vector<Text>& expressions, std::string_view name) {
  return std::ranges::any_of(expressions,
                             [&](const Text& text) { return matches_as(product, text, name); });
}

bool lists(Product product, const Criteria& criteria, std::string_view partition) {
  return criteria.partitions ? any_matches(product, *criteria.partitions, partition)
                             : partition.empty();
}

// An allow_rule must list all of an entity's partitions, a deny_rule one of them.
bool fits_cyclonedds(bool allow, const Criteria& criteria, Partitions partitions) {
  const auto listed = [&](std::string_view partition) {
    return lists(Product::cyclonedds, criteria, partition);
  };
  return allow ? std::ranges::all_of(partitions, listed) : std::ranges::any_of(partitions, listed);
}

// The topic and its partitions may be in different elements of one rule.
bool fits_fastdds(const std::vector<Criteria>& list, Partitions partitions) {
  return std::ranges::all_of(partitions, [&](std::string_view partition) {
    return std::ranges::any_of(list, [&](const Criteria& criteria) {
      return lists(Product::fastdds, criteria, partition);
    });
  });
}

// If `domain` is empty, each rule counts, whatever its domains are.
Decision judge_by_rules(Product product, const CompiledGrant& grant, std::optional<DomainId> domain,
                        Action action, const Request& request) {
  constexpr std::array<std::string_view, 1> kDefaultPartition{""};
  const auto partitions =
      request.partitions.empty() ? Partitions(kDefaultPartition) : request.partitions;
  for (const auto& rule : grant.grant().rules) {
    if (domain && !rule.domains.contains_for_stock(*domain)) continue;
    const auto& list = action == Action::publish ? rule.publish : rule.subscribe;
    if (product == Product::fastdds) {
      if (const auto* criteria = naming(product, list, request.topic))
        return {rule.allow && fits_fastdds(list, partitions), &rule, criteria};
      continue;
    }
    for (const auto& criteria : list)
      if (any_matches(product, criteria.topics, request.topic) &&
          fits_cyclonedds(rule.allow, criteria, partitions))
        return {rule.allow, &rule, &criteria};
  }
  return {.allowed = grant.grant().default_allow && product != Product::fastdds};
}

}  // namespace

// Fast DDS keeps blanks around an expression, and no topic name has any, so a padded expression
// never matches (measured: Fast DDS 2.9.1, topics of both documents).
bool matches_as(Product product, const Text& expression, std::string_view name) {
  if (product == Product::fastdds && expression.is_padded) return false;
  return reads_as_match(product, expression.text, name);
}

const DomainRule* domain_rule_as(Product product, const Governance& governance, DomainId domain) {
  return product == Product::ddssec ? governance.find(domain) : governance.find_for_stock(domain);
}

const TopicRule* topic_rule_as(Product product, const DomainRule& domain, std::string_view topic) {
  const auto found = std::ranges::find_if(domain.topic_rules, [&](const TopicRule& rule) {
    return matches_as(product, {rule.topic_expression, rule.line, rule.is_padded}, topic);
  });
  return found == domain.topic_rules.end() ? nullptr : &*found;
}

const Criteria* naming(Product product, const std::vector<Criteria>& list, std::string_view topic) {
  const auto found = std::ranges::find_if(
      list, [&](const Criteria& criteria) { return any_matches(product, criteria.topics, topic); });
  return found == list.end() ? nullptr : &*found;
}

const governance::GrantRule* first_rule_naming(const Grant& grant, DomainId domain,
                                               std::string_view topic) {
  const auto found = std::ranges::find_if(grant.rules, [&](const GrantRule& rule) {
    return rule.domains.contains_for_stock(domain) &&
           (naming(Product::cyclonedds, rule.publish, topic) != nullptr ||
            naming(Product::cyclonedds, rule.subscribe, topic) != nullptr);
  });
  return found == grant.rules.end() ? nullptr : &*found;
}

Decision judge_local_as(Product product, const CompiledGrant& grant, DomainId domain, Action action,
                        const Request& request) {
  if (product == Product::fastdds)
    return judge_by_rules(product, grant, std::nullopt, action, request);
  return judge_as(product, grant, domain, action, request);
}

Decision judge_as(Product product, const CompiledGrant& grant, DomainId domain, Action action,
                  const Request& request) {
  if (product == Product::ddssec) return grant.judge(action, request);
  return judge_by_rules(product, grant, domain, action, request);
}

Validity validity_as(Product product, const Validity& validity) {
  if (product == Product::ddssec) return validity;
  return rewritten_for(
      validity, product == Product::cyclonedds ? StockProduct::cyclonedds : StockProduct::fastdds);
}

Decision judge_participant_as(Product product, const CompiledGrant& grant, DomainId domain) {
  if (product == Product::ddssec) return grant.judge_participant();
  const auto& rules = grant.grant().rules;
  const auto found = std::ranges::find_if(rules, [&](const GrantRule& rule) {
    return rule.allow && rule.domains.contains_for_stock(domain);
  });
  if (found != rules.end()) return {true, &*found, nullptr};
  return {.allowed = grant.grant().default_allow && product != Product::fastdds};
}

}  // namespace ddssec::governance::doctor
