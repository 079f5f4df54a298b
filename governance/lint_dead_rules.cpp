#include <algorithm>
#include <map>
#include <set>

#include <fmt/format.h>

#include "governance/domain_cuts.hpp"
#include "governance/lint_grant.hpp"
#include "governance/pattern.hpp"
#include "governance/shadowed_expressions.hpp"
#include "governance/topic_sets.hpp"
#include "pki/subject_name.hpp"

namespace ddssec::governance {
namespace {

using enum Rule;

bool within(const DomainSet& inner, const DomainSet& outer) {
  if (inner == outer) return true;
  const bool is_tagged = !inner.tags.empty() || !inner.tag_expressions.empty() ||
                         !outer.tags.empty() || !outer.tag_expressions.empty();
  if (is_tagged) return false;
  const auto merged = joined(outer.ranges);
  return std::ranges::all_of(inner.ranges, [&](const DomainRange& range) {
    return std::ranges::any_of(merged, [&](const DomainRange& o) {
      return o.first <= range.first && range.last <= o.last;
    });
  });
}

bool overlaps(const DomainSet& a, const DomainSet& b) {
  return within(a, b) || std::ranges::any_of(a.ranges, [&](const DomainRange& one) {
           return std::ranges::any_of(b.ranges, [&](const DomainRange& other) {
             return one.first <= other.last && other.first <= one.last;
           });
         });
}

}  // namespace

std::vector<std::string_view> allowed_partitions(const Criteria& criteria) {
  if (!criteria.partitions) return {""};
  std::vector<std::string_view> out;
  for (const auto& partition : *criteria.partitions) out.emplace_back(partition.text);
  return out;
}

std::vector<std::string_view> denied_partitions(const GrantEntry& denial) {
  if (!denial.criteria->partitions) return {"*"};
  return allowed_partitions(*denial.criteria);
}

bool allows_before(const GrantEntry& earlier, const GrantEntry& denial, SetEffort& effort) {
  return earlier.rule->allow && !denial.rule->allow &&
         overlaps(denial.rule->domains, earlier.rule->domains) &&
         overlap(denied_partitions(denial), allowed_partitions(*earlier.criteria),
                 limits_of_pair(effort))
                 .kind == SetAnswer::Kind::yes;
}

namespace {

// True if entities with partitions or data tags can have rights of their own.
bool conditions_matter(const Grant& grant) {
  const auto has = [](const Criteria& c) { return c.partitions || c.data_tags; };
  return grant.default_allow || std::ranges::any_of(grant.rules, [&](const GrantRule& rule) {
           return rule.allow && (std::ranges::any_of(rule.publish, has) ||
                                 std::ranges::any_of(rule.subscribe, has));
         });
}

// True if the earlier element matches every set of partitions that the later one matches. An allow
// rule must list all of an entity's partitions, a deny rule one.
bool partitions_cover(const GrantEntry& earlier, const GrantEntry& later, SetEffort& effort) {
  if (!earlier.rule->allow && !earlier.criteria->partitions) return true;
  if (!later.rule->allow && (earlier.rule->allow || !later.criteria->partitions)) return false;
  const auto inner = allowed_partitions(*later.criteria);
  const auto outer = allowed_partitions(*earlier.criteria);
  return contained(inner, outer, limits_of_pair(effort)).kind == SetAnswer::Kind::yes;
}

bool tags_cover(const GrantEntry& earlier, const GrantEntry& later) {
  if (!earlier.rule->allow && !earlier.criteria->data_tags) return true;
  return earlier.rule->allow == later.rule->allow &&
         earlier.criteria->data_tags == later.criteria->data_tags;
}

// If conditions do not matter, the allow rules without them define all rights, and no later denial
// removes anything.
bool covers(const GrantEntry& earlier, const GrantEntry& later, bool with_conditions,
            SetEffort& effort) {
  if (!within(later.rule->domains, earlier.rule->domains)) return false;
  if (earlier.rule->allow && !with_conditions) return true;
  return tags_cover(earlier, later) && partitions_cover(earlier, later, effort);
}

// True if an allow rule is for each domain and partition of the denial. A rule without partitions
// is for the partition "" alone, and a denial that names none either may mean just that one.
bool allows_everywhere(const GrantEntry& allowed, const GrantEntry& denial, SetEffort& effort) {
  if (!within(denial.rule->domains, allowed.rule->domains)) return false;
  if (!allowed.criteria->partitions && !denial.criteria->partitions) return true;
  return contained(denied_partitions(denial), allowed_partitions(*allowed.criteria),
                   limits_of_pair(effort))
             .kind == SetAnswer::Kind::yes;
}

// True for a denial of topics that neither a later rule nor the default would allow without it.
bool denies_nothing_else(const Grant& grant, std::span<const GrantEntry> entries, std::size_t at,
                         SetEffort& effort) {
  if (grant.default_allow || entries[at].rule->allow) return false;
  const std::string_view denied[] = {entries[at].topic->text};
  return std::ranges::none_of(entries.subspan(at + 1), [&](const GrantEntry& later) {
    const std::string_view allowed[] = {later.topic->text};
    return later.rule->allow &&
           overlap(denied, allowed, limits_of_pair(effort)).kind != SetAnswer::Kind::no;
  });
}

// An expression without effect, and the expressions that take its effect.
struct DeadEntry {
  GrantEntry entry;
  std::vector<GrantEntry> by;
  std::string_view action;
  // True if the denial has no effect although it could apply: earlier rules already allow
  // everything that it names, in the domains and partitions that they list.
  bool is_void = false;
  bool is_void_everywhere = false;  // earlier rules allow it in all domains and partitions
};

std::vector<DeadEntry> dead_entries(const GrantPlace& place, SetEffort& effort) {
  std::vector<DeadEntry> out;
  const bool with_conditions = conditions_matter(place.grant());
  for (std::size_t action = 0; action < kActionNames.size(); ++action) {
    const auto& entries = place.actions()[action];
    std::vector<std::string_view> texts;
    for (const auto& entry : entries) texts.emplace_back(entry.topic->text);
    const auto found = shadows(texts, effort, [&](std::uint32_t a, std::uint32_t b) {
      return covers(entries[a], entries[b], with_conditions, effort);
    });
    const auto anywhere = shadows(texts, effort, [&](std::uint32_t a, std::uint32_t b) {
      return allows_before(entries[a], entries[b], effort);
    });
    for (std::size_t i = 0; i < found.size(); ++i) {
      const bool is_void = !found[i].is_dead && anywhere[i].is_dead && !anywhere[i].by.empty() &&
                           denies_nothing_else(place.grant(), entries, i, effort);
      if (!found[i].is_dead && !is_void) continue;
      DeadEntry dead{entries[i], {}, kActionNames[action], is_void};
      for (const auto by : is_void ? anywhere[i].by : found[i].by) dead.by.push_back(entries[by]);
      dead.is_void_everywhere = is_void && std::ranges::all_of(dead.by, [&](const auto& by) {
                                  return allows_everywhere(by, entries[i], effort);
                                });
      out.push_back(std::move(dead));
    }
  }
  return out;
}

// It is an error if something that should be denied is allowed. A repetition is harmless. If an
// earlier rule allows the topic in some partitions, the denial may be meant for the others.
Severity severity_of(const DeadEntry& dead) {
  if (dead.is_void) return dead.is_void_everywhere ? Severity::error : Severity::warning;
  const bool same = !dead.by.empty() && std::ranges::all_of(dead.by, [&](const GrantEntry& by) {
    return by.rule->allow == dead.entry.rule->allow;
  });
  if (same) return Severity::informational;
  return dead.entry.rule->allow ? Severity::warning : Severity::error;
}

bool is_read_as_less(const DomainSet& domains) {
  return std::ranges::any_of(domains.ranges, [](const DomainRange& range) {
    return range.is_open && range.first != range.last;
  });
}

std::string reason(const DeadEntry& dead) {
  if (dead.by.empty()) return matches_nothing(dead.entry.topic->text);
  std::vector<std::string> names;
  for (const auto& by : dead.by)
    names.push_back(
        fmt::format("{} ({}, line {})", in_quotes(by.topic->text), rule_name(by), by.topic->line));
  const bool is_for_all = std::ranges::none_of(
      dead.by, [](const GrantEntry& by) { return is_read_as_less(by.rule->domains); });
  return fmt::format("{} already decide{} for every name it matches{}{}", fmt::join(names, ", "),
                     names.size() == 1 ? "s" : "",
                     dead.is_void ? " in its domains and partitions" : "",
                     is_for_all ? ""
                                : "; but not with Cyclone DDS and Fast DDS, which read an "
                                  "<id_range> without <max> as one domain");
}

// The hint; empty: the rule's own. An earlier expression with no other names could never apply if
// the dead one stood before it.
std::string hint_for(const DeadEntry& dead, SetEffort& effort) {
  if (dead.by.empty()) return std::string(kUnmatchableHint);
  const std::string_view moved[] = {dead.entry.topic->text};
  const auto is_taken = [&](const GrantEntry& by) {
    const std::string_view earlier[] = {by.topic->text};
    return contained(earlier, moved, limits_of_pair(effort)).kind == SetAnswer::Kind::yes;
  };
  const auto taken = std::ranges::find_if(dead.by, is_taken);
  if (taken == dead.by.end()) return {};
  return fmt::format(
      "delete it, or {} in line {} if this one is meant to count: moved before that, it would "
      "take all of its names",
      in_quotes(taken->topic->text), taken->topic->line);
}

std::string_view fault(const DeadEntry& dead) {
  return dead.is_void ? "denies nothing that would be allowed without it" : "can never apply";
}

// The number of expressions of each rule, by the rule's number.
std::vector<std::size_t> entries_by_rule(const GrantPlace& place) {
  std::vector<std::size_t> out(place.grant().rules.size() + 1);
  for (const auto& entries : place.actions())
    for (const auto& entry : entries) ++out[entry.rule_number];
  return out;
}

void add_rule(LintFindings& out, const GrantPlace& place,
              const std::vector<const DeadEntry*>& all) {
  const auto& first = *all.front();
  auto finding = place.about_rule(
      PERM012, first.entry.rule_number,
      fmt::format("{} {}: to {} {}, {}", rule_name(first.entry), fault(first), first.action,
                  in_quotes(first.entry.topic->text), reason(first)));
  finding.severity = Severity::informational;
  finding.hint = hint_for(first, out.effort());
  for (const auto* dead : all) finding.severity = std::max(finding.severity, severity_of(*dead));
  out.add(std::move(finding));
}

}  // namespace

std::set<const Text*> lint_dead_rules(LintFindings& out, const GrantPlace& place) {
  const auto dead = dead_entries(place, out.effort());
  std::set<const Text*> reported;
  std::map<std::size_t, std::vector<const DeadEntry*>> by_rule;
  for (const auto& one : dead) {
    by_rule[one.entry.rule_number].push_back(&one);
    reported.insert(one.entry.topic);
  }
  const auto counts = entries_by_rule(place);
  for (const auto& [number, all] : by_rule) {
    if (all.size() == counts[number]) {
      add_rule(out, place, all);
      continue;
    }
    for (const auto* one : all) {
      auto finding = place.about(
          PERM012, one->entry,
          fmt::format("to {} {} {} in {}: {}", one->action, in_quotes(one->entry.topic->text),
                      fault(*one), rule_name(one->entry), reason(*one)));
      finding.severity = severity_of(*one);
      finding.hint = hint_for(*one, out.effort());
      out.add(std::move(finding));
    }
  }
  return reported;
}

void lint_unmatchable(LintFindings& out, const GrantPlace& place) {
  const auto add = [&](std::string_view what, const Text& text, Finding finding) {
    finding.message = fmt::format("{} can never apply: {}", what, matches_nothing(text.text));
    finding.hint = kUnmatchableHint;
    finding.line = text.line;
    out.add(std::move(finding));
  };
  const auto check = [&](std::string_view what, const Text& text, std::size_t rule) {
    if (!Pattern(text.text).matches_no_name()) return;
    auto finding = place.about_rule(PERM012, rule + 1, {});
    if (!place.grant().rules[rule].allow) finding.severity = Severity::error;
    add(what, text, std::move(finding));
  };
  const auto& grant = place.grant();
  for (std::size_t i = 0; i < grant.rules.size(); ++i) {
    const auto& rule = grant.rules[i];
    for (const auto& tag : rule.domains.tag_expressions) check("a <tag_expression>", tag, i);
    for (const auto* list : {&rule.publish, &rule.subscribe, &rule.relay})
      for (const auto& criteria : *list)
        for (const auto& partition : listed_partitions(criteria))
          check("a <partition>", partition, i);
    for (const auto& criteria : rule.relay)
      for (const auto& topic : criteria.topics) check("a relayed <topic>", topic, i);
  }
  if (!grant.subject_is_expression) return;
  const auto name = pki::SubjectName::parse(grant.subject_name);
  const bool is_dead =
      name && std::ranges::any_of(name->attributes(), [](const auto& attribute) {
        return Pattern(attribute.value, Pattern::Syntax::subject).matches_no_name();
      });
  if (is_dead)
    add("the grant", {grant.subject_name, grant.line}, place.about(PERM012, std::string()));
}

}  // namespace ddssec::governance
