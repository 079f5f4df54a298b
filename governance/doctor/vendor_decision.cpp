#include "governance/doctor/vendor_decision.hpp"

#include <algorithm>
#include <array>

namespace ddssec::governance::doctor {
namespace {

using Partitions = std::span<const std::string_view>;

bool lists(const Criteria& criteria, std::string_view partition) {
  if (!criteria.partitions) return partition.empty();
  return std::ranges::any_of(*criteria.partitions, [&](const Text& text) {
    return Pattern(text.text).matches(partition);
  });
}

// All of an entity's partitions for an allow_rule, one of them for a deny_rule.
bool fits_cyclonedds(bool allow, const Criteria& criteria, Partitions partitions) {
  const auto listed = [&](std::string_view partition) { return lists(criteria, partition); };
  return allow ? std::ranges::all_of(partitions, listed) : std::ranges::any_of(partitions, listed);
}

// The topic and its partitions may stand in different elements of one rule.
bool fits_fastdds(const std::vector<Criteria>& list, Partitions partitions) {
  return std::ranges::all_of(partitions, [&](std::string_view partition) {
    return std::ranges::any_of(
        list, [&](const Criteria& criteria) { return lists(criteria, partition); });
  });
}

bool names(const Criteria& criteria, std::string_view topic) {
  return std::ranges::any_of(criteria.topics,
                             [&](const Text& text) { return Pattern(text.text).matches(topic); });
}

}  // namespace

const Criteria* naming(const std::vector<Criteria>& list, std::string_view topic) {
  const auto found =
      std::ranges::find_if(list, [&](const Criteria& criteria) { return names(criteria, topic); });
  return found == list.end() ? nullptr : &*found;
}

const governance::Rule* first_rule_naming(const Grant& grant, DomainId domain,
                                          std::string_view topic) {
  const auto found = std::ranges::find_if(grant.rules, [&](const Rule& rule) {
    return rule.domains.contains(domain) &&
           (naming(rule.publish, topic) != nullptr || naming(rule.subscribe, topic) != nullptr);
  });
  return found == grant.rules.end() ? nullptr : &*found;
}

Verdict judge_as(Vendor vendor, const CompiledGrant& grant, DomainId domain, Action action,
                 const Request& request) {
  if (vendor == Vendor::ours) return grant.judge(action, request);
  constexpr std::array<std::string_view, 1> kDefaultPartition{""};
  const auto partitions =
      request.partitions.empty() ? Partitions(kDefaultPartition) : request.partitions;
  for (const auto& rule : grant.grant().rules) {
    if (!rule.domains.contains_for_stock(domain)) continue;
    const auto& list = action == Action::publish ? rule.publish : rule.subscribe;
    if (vendor == Vendor::fastdds) {
      if (const auto* criteria = naming(list, request.topic))
        return {rule.allow && fits_fastdds(list, partitions), &rule, criteria};
      continue;
    }
    for (const auto& criteria : list)
      if (names(criteria, request.topic) && fits_cyclonedds(rule.allow, criteria, partitions))
        return {rule.allow, &rule, &criteria};
  }
  return {.allowed = grant.grant().default_allow && vendor != Vendor::fastdds};
}

Verdict judge_participant_as(Vendor vendor, const CompiledGrant& grant, DomainId domain) {
  if (vendor == Vendor::ours) return grant.judge_participant();
  const auto& rules = grant.grant().rules;
  const auto found = std::ranges::find_if(rules, [&](const Rule& rule) {
    return rule.allow && rule.domains.contains_for_stock(domain);
  });
  if (found != rules.end()) return {true, &*found, nullptr};
  return {.allowed = grant.grant().default_allow && vendor != Vendor::fastdds};
}

}  // namespace ddssec::governance::doctor
