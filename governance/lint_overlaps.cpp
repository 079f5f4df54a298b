// Rules that take some names from a later rule, as `A*` takes AB from `*B`: the first rule that
// matches decides (DDS-Security 1.2, clauses 10.4.1.2.6 and 10.4.1.5.3.4). If the earlier
// expression has no other names than the later one, it is an exception from it, and meant to be.
#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "governance/lint_access.hpp"
#include "governance/lint_grant.hpp"
#include "governance/pattern.hpp"
#include "governance/topic_sets.hpp"

namespace ddssec::governance {
namespace {

using enum Rule;

// The work for one grant or domain rule, so that a long document is not compared for minutes.
struct Budget {
  int comparisons = 2'000;  // pairs of expressions that are compared
  int steps = 2'000'000;    // pairs of rules that are looked at

  bool is_spent() const { return comparisons <= 0 || steps <= 0; }
};

bool is_one_name(std::string_view expression) { return Pattern(expression).is_literal(); }

bool is_within(std::string_view inner, std::string_view outer, SetEffort& effort) {
  const std::string_view a[] = {inner}, b[] = {outer};
  return contained(a, b, limits_of_pair(effort)).kind != SetAnswer::Kind::no;
}

// A name that both match, if it is known that there is one.
std::optional<std::string> common_name(std::string_view one, std::string_view other,
                                       SetEffort& effort) {
  const std::string_view a[] = {one}, b[] = {other};
  auto answer = overlap(a, b, limits_of_pair(effort));
  if (answer.kind != SetAnswer::Kind::yes) return std::nullopt;
  return answer.witness;
}

// ---- permissions

struct TakenName {
  const GrantEntry& by;
  std::string topic;
  std::string partition;  // empty: it is the same for both
};

// True if all that `allowed` allows would be denied without it.
bool is_exception(const GrantEntry& allowed, const GrantEntry& denial, SetEffort& effort) {
  return is_within(allowed.topic->text, denial.topic->text, effort) &&
         contained(allowed_partitions(*allowed.criteria), denied_partitions(denial),
                   limits_of_pair(effort))
                 .kind != SetAnswer::Kind::no;
}

// True if a deny rule denies it before.
bool is_denied_before(std::span<const GrantEntry> earlier, const std::string& topic) {
  return std::ranges::any_of(earlier, [&](const GrantEntry& one) {
    return !one.rule->allow && Pattern(one.topic->text).matches(topic);
  });
}

// True if the entry can allow something besides one topic in the default partition.
bool allows_several(const GrantEntry& entry) {
  return entry.rule->allow && (!is_one_name(entry.topic->text) || entry.criteria->partitions);
}

// `wide`: the indexes of the entries before the denial for which allows_several() is true.
std::optional<TakenName> name_taken_from(std::span<const GrantEntry> entries,
                                         const GrantEntry& denial,
                                         std::span<const std::size_t> wide, Budget& budget,
                                         SetEffort& effort) {
  const bool is_one = is_one_name(denial.topic->text) && !denial.criteria->partitions;
  for (const auto i : wide) {
    --budget.steps;
    if (budget.is_spent()) return std::nullopt;
    const auto& allowed = entries[i];
    if (allowed.rule == denial.rule || (is_one && is_one_name(allowed.topic->text))) continue;
    --budget.comparisons;
    auto topic = common_name(allowed.topic->text, denial.topic->text, effort);
    if (!topic || !allows_before(allowed, denial, effort) || is_exception(allowed, denial, effort))
      continue;
    budget.steps -= static_cast<int>(i);
    if (is_denied_before(entries.first(i), *topic)) continue;
    TakenName out{allowed, *std::move(topic), {}};
    if (allowed.criteria->partitions && denial.criteria->partitions)
      out.partition = overlap(denied_partitions(denial), allowed_partitions(*allowed.criteria),
                              limits_of_pair(effort))
                          .witness;
    return out;
  }
  return std::nullopt;
}

// ---- governance

bool is_more(ProtectionKind a, ProtectionKind b) {
  return (is_protected(a) && !is_protected(b)) || (is_encrypted(a) && !is_encrypted(b)) ||
         (is_origin_authenticated(a) && !is_origin_authenticated(b));
}

bool is_more(bool a, bool b) { return a && !b; }

// True if the later rule protects something that the earlier one does not, or not as much.
bool protects_more(const TopicRule& later, const TopicRule& earlier) {
  return is_more(later.enable_discovery_protection, earlier.enable_discovery_protection) ||
         is_more(later.enable_liveliness_protection, earlier.enable_liveliness_protection) ||
         is_more(later.enable_read_access_control, earlier.enable_read_access_control) ||
         is_more(later.enable_write_access_control, earlier.enable_write_access_control) ||
         is_more(later.metadata_protection_kind, earlier.metadata_protection_kind) ||
         is_more(later.data_protection_kind, earlier.data_protection_kind);
}

// True if the first rule that matches the name is that one.
bool decides(const std::vector<TopicRule>& rules, std::size_t at, const std::string& name) {
  return std::ranges::none_of(
      rules.begin(), rules.begin() + static_cast<std::ptrdiff_t>(at),
      [&](const TopicRule& rule) { return Pattern(rule.topic_expression).matches(name); });
}

struct TakenTopic {
  std::size_t by;
  std::string name;
};

std::optional<TakenTopic> topic_taken_from(const std::vector<TopicRule>& rules, std::size_t at,
                                           Budget& budget, SetEffort& effort) {
  const auto& later = rules[at].topic_expression;
  for (std::size_t i = 0; i < at; ++i) {
    const auto& earlier = rules[i].topic_expression;
    --budget.steps;
    if (budget.is_spent()) return std::nullopt;
    if (!protects_more(rules[at], rules[i]) || is_one_name(earlier)) continue;
    --budget.comparisons;
    auto name = common_name(earlier, later, effort);
    if (!name || is_within(earlier, later, effort) || is_within(later, earlier, effort) ||
        !decides(rules, i, *name))
      continue;
    return TakenTopic{i, *std::move(name)};
  }
  return std::nullopt;
}

}  // namespace

void lint_overlaps(LintFindings& out, const GrantPlace& place,
                   const std::set<const Text*>& reported) {
  Budget budget;
  for (std::size_t action = 0; action < kActionNames.size(); ++action) {
    const std::span entries(place.actions()[action]);
    std::vector<std::size_t> wide;
    for (std::size_t i = 0; i < entries.size(); ++i) {
      const auto& denial = entries[i];
      if (allows_several(denial)) wide.push_back(i);
      if (denial.rule->allow || wide.empty() || reported.contains(denial.topic)) continue;
      const auto taken = name_taken_from(entries, denial, wide, budget, out.effort());
      if (!taken) continue;
      const auto where =
          taken->partition.empty() ? std::string() : " in partition " + in_quotes(taken->partition);
      out.add(place.about(
          PERM016, denial,
          fmt::format("{} does not deny to {} {}{}: {} ({}, line {}) matches it, too, and comes "
                      "before {}",
                      rule_name(denial), kActionNames[action], in_quotes(taken->topic), where,
                      in_quotes(taken->by.topic->text), rule_name(taken->by), taken->by.topic->line,
                      in_quotes(denial.topic->text))));
    }
  }
}

void diagnose_overlaps(LintFindings& out, const DomainPlace& place) {
  const auto& rules = place.rule.topic_rules;
  Budget budget;
  for (std::size_t i = 1; i < rules.size(); ++i) {
    if (is_one_name(rules[i].topic_expression)) continue;
    const auto taken = topic_taken_from(rules, i, budget, out.effort());
    if (!taken) continue;
    out.add(place.about(
        GOV014, i,
        fmt::format("topic_rule {} {} does not protect {}: {} (rule {}) matches it, too, comes "
                    "before, and protects less",
                    i + 1, in_quotes(rules[i].topic_expression), in_quotes(taken->name),
                    in_quotes(rules[taken->by].topic_expression), taken->by + 1)));
  }
}

}  // namespace ddssec::governance
