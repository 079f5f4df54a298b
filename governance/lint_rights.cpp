#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "governance/decision.hpp"
#include "governance/domain_cuts.hpp"
#include "governance/lint_grant.hpp"
#include "governance/pattern_set.hpp"
#include "governance/topic_sets.hpp"

namespace ddssec::governance {
namespace {

using enum Rule;

constexpr SetLimits kLimits{.states = 20'000, .atoms = 5'000, .steps = 20'000'000};
// The largest numbers of pairs of expressions, and of deny rules, whose effect in one product is
// examined.
constexpr int kMaxComparisons = 2'000;
constexpr int kMaxDenyRules = 50;

std::vector<std::string_view> texts_of(const std::vector<Criteria>& list) {
  std::vector<std::string_view> out;
  for (const auto& criteria : list)
    for (const auto& topic : criteria.topics) out.emplace_back(topic.text);
  return out;
}

void diagnose_expressions(LintFindings& out, const GrantPlace& place) {
  for (const auto& entries : place.actions())
    for (const auto& entry : entries) {
      out.add_if_unportable(PERM013, *entry.topic, place.rule_path(entry.rule_number));
      out.add_if_ros_name(PERM034, *entry.topic, place.rule_path(entry.rule_number));
    }
  // Stock products ignore relay elements.
  const auto& rules = place.grant().rules;
  for (std::size_t i = 0; i < rules.size(); ++i)
    for (const auto* list : {&rules[i].publish, &rules[i].subscribe})
      for (const auto& criteria : *list)
        for (const auto& partition : listed_partitions(criteria))
          out.add_if_unportable(PERM013, partition, place.rule_path(i + 1));
}

void diagnose_unread_conditions(LintFindings& out, const GrantPlace& place) {
  const auto& rules = place.grant().rules;
  const auto has_tags = [](const Criteria& c) { return c.data_tags.has_value(); };
  for (std::size_t i = 0; i < rules.size(); ++i) {
    const auto& rule = rules[i];
    const auto add = [&](std::string_view what, Severity severity) {
      auto finding = place.about_rule(
          PERM014, i + 1,
          fmt::format("rule {} has {}: Cyclone DDS and Fast DDS ignore them", i + 1, what));
      finding.products = stock_products();
      finding.severity = severity;
      out.add(std::move(finding));
    };
    if (std::ranges::any_of(rule.publish, has_tags) ||
        std::ranges::any_of(rule.subscribe, has_tags))
      add("data tags", Severity::warning);
    if (!rule.relay.empty()) add("relay elements", Severity::informational);
  }
}

// Fast DDS stops at the first rule whose topic matches, whatever its partitions are.
void diagnose_partitions_by_rule(LintFindings& out, const GrantPlace& place,
                                 const std::vector<GrantEntry>& entries) {
  const auto has_partitions = [](const GrantEntry& e) {
    return e.criteria->partitions.has_value();
  };
  if (std::ranges::none_of(entries, has_partitions)) return;
  PatternSet patterns;
  std::vector<const GrantEntry*> first;
  for (const auto& entry : entries)
    if (patterns.add(entry.topic->text) == first.size()) first.push_back(&entry);
  patterns.seal();
  for (const auto& entry : entries) {
    std::vector<PatternSet::Id> ids;
    if (!patterns.match(entry.topic->text, ids, out.effort().plain_steps)) return;
    if (ids.empty() || first[ids.front()]->rule_number >= entry.rule_number) continue;
    const auto& earlier = *first[ids.front()];
    if (!entry.rule->allow || earlier.criteria->partitions == entry.criteria->partitions) continue;
    auto finding =
        place.about(PERM015, entry,
                    fmt::format("{}: {} matches it for other partitions, and Fast DDS stops there",
                                in_quotes(entry.topic->text), rule_name(earlier)));
    finding.products = {kFastDds};
    out.add(std::move(finding));
  }
}

// Fast DDS looks for the partitions in all elements of the rule that decides.
void diagnose_joined_partitions(LintFindings& out, const GrantPlace& place,
                                const std::vector<GrantEntry>& entries) {
  const auto partitions_of = [](const GrantEntry& entry) {
    return entry.criteria->partitions.value_or(std::vector<Text>{Text{}});
  };
  const GrantEntry* first = nullptr;
  std::size_t told = 0;  // number of the rule that was reported last
  for (const auto& entry : entries) {
    if (first == nullptr || first->rule_number != entry.rule_number) first = &entry;
    const bool is_known = told == entry.rule_number || !entry.rule->allow;
    if (is_known || partitions_of(*first) == partitions_of(entry)) continue;
    told = entry.rule_number;
    auto finding = place.about(
        PERM015, entry,
        fmt::format("{}: other partitions than for {} in the same rule, and Fast DDS allows each "
                    "topic of a rule in the partitions of all its elements",
                    in_quotes(entry.topic->text), in_quotes(first->topic->text)));
    finding.hint = "write a rule of its own for each list of partitions";
    finding.products = {kFastDds};
    out.add(std::move(finding));
  }
}

// Expression lists for one search: a topic that this deny_rule denies in one direction and a later
// allow_rule allows in the other. Each list has one role in the search.
struct HalfDenial {
  std::vector<std::string_view> denied, also_denied, named_before, allowed_later;

  // Returns a name that is in the first and the last list and in none of the others.
  std::optional<std::string> witness(SetEffort& effort) const {
    std::vector<RankedExpression> all;
    const std::vector<std::string_view>* lists[] = {&denied, &also_denied, &named_before,
                                                    &allowed_later};
    for (std::uint32_t list = 0; list < std::size(lists); ++list)
      for (const auto text : *lists[list]) all.push_back({text, list, 0});
    const auto atoms = name_atoms(all, kLimits.sharing(effort));
    if (!atoms) return std::nullopt;
    for (const auto& atom : *atoms)
      if (atom.rank_in(0) && !atom.rank_in(1) && !atom.rank_in(2) && atom.rank_in(3))
        return atom.witness;
    return std::nullopt;
  }
};

void append(std::vector<std::string_view>& to, const std::vector<std::string_view>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

void diagnose_half_denied(LintFindings& out, const GrantPlace& place, std::size_t at,
                          Action action) {
  const auto& rules = place.grant().rules;
  const auto half = [](const GrantRule& rule, Action of) {
    return texts_of(of == Action::publish ? rule.publish : rule.subscribe);
  };
  const bool publish = action == Action::publish;
  const Action other = publish ? Action::subscribe : Action::publish;
  HalfDenial lists{half(rules[at], action), half(rules[at], other), {}, {}};
  if (lists.denied.empty()) return;
  for (std::size_t i = 0; i < rules.size(); ++i) {
    if (i < at) append(lists.named_before, half(rules[i], Action::publish));
    if (i < at) append(lists.named_before, half(rules[i], Action::subscribe));
    if (i > at && rules[i].allow) append(lists.allowed_later, half(rules[i], other));
    // If a topic is also denied in the other direction before any rule allows it, it is really
    // denied.
    if (i > at && !rules[i].allow) append(lists.also_denied, half(rules[i], other));
  }
  const auto witness = lists.witness(out.effort());
  if (!witness) return;
  auto finding = place.about_rule(
      PERM020, at + 1,
      fmt::format("deny_rule {} denies {} {}, and a later allow_rule allows {} it: Cyclone "
                  "DDS refuses the topic altogether",
                  at + 1, publish ? "publishing" : "subscribing to", in_quotes(*witness),
                  publish ? "subscribing to" : "publishing"));
  finding.products = {kCyclone};
  out.add(std::move(finding));
}

void diagnose_denials(LintFindings& out, const GrantPlace& place) {
  const auto& rules = place.grant().rules;
  int denials = 0;
  for (std::size_t i = 0; i < rules.size(); ++i) {
    if (rules[i].allow || ++denials > kMaxDenyRules) continue;
    diagnose_half_denied(out, place, i, Action::publish);
    diagnose_half_denied(out, place, i, Action::subscribe);
  }
}

// Returns the entries of allow rules with listed partitions, in document order.
std::vector<const GrantEntry*> allowed_in_partitions(const std::vector<GrantEntry>& entries) {
  std::vector<const GrantEntry*> out;
  for (const auto& entry : entries)
    if (entry.rule->allow && entry.criteria->partitions) out.push_back(&entry);
  return out;
}

// Cyclone DDS gives a deny rule without partitions the default partition.
void diagnose_open_denial(LintFindings& out, const GrantPlace& place,
                          const std::vector<GrantEntry>& entries) {
  const auto allowed = allowed_in_partitions(entries);
  const auto number_of = [](const GrantEntry* entry) { return entry->rule_number; };
  int comparisons = 0;
  for (const auto& entry : entries) {
    if (entry.rule->allow || entry.criteria->partitions) continue;
    const auto overlaps = [&](const GrantEntry* other) {
      if (++comparisons > kMaxComparisons) return false;
      const std::string_view a[] = {entry.topic->text};
      const std::string_view b[] = {other->topic->text};
      return overlap(a, b, kLimits.sharing(out.effort())).kind == SetAnswer::Kind::yes;
    };
    const auto first = std::ranges::upper_bound(allowed, entry.rule_number, {}, number_of);
    const auto found = std::find_if(first, allowed.end(), overlaps);
    if (comparisons > kMaxComparisons) return;
    if (found == allowed.end()) continue;
    const auto* later = *found;
    auto finding = place.about(
        PERM021, entry,
        fmt::format("{} denies {} in every partition, but in Cyclone DDS in the default partition "
                    "only, and {} allows {} in partition {}",
                    rule_name(entry), in_quotes(entry.topic->text), rule_name(*later),
                    in_quotes(later->topic->text),
                    in_quotes(later->criteria->partitions->front().text)));
    finding.products = {kCyclone};
    out.add(std::move(finding));
    return;  // one example for each direction
  }
}

bool lists_partitions(const GrantRule& rule) {
  const auto listed = [](const Criteria& c) { return c.partitions.has_value(); };
  return std::ranges::any_of(rule.publish, listed) || std::ranges::any_of(rule.subscribe, listed);
}

// Measured with Cyclone DDS 0.10.2: it creates no topic whose first rule is a deny_rule, and
// partitions do not count in that decision.
void diagnose_topic_denied_with_partitions(LintFindings& out, const GrantPlace& place,
                                           std::size_t at) {
  const auto& rules = place.grant().rules;
  HalfDenial lists;
  for (std::size_t i = 0; i < rules.size(); ++i) {
    auto* const list = i < at           ? &lists.named_before
                       : i == at        ? &lists.denied
                       : rules[i].allow ? &lists.allowed_later
                                        : nullptr;
    if (list == nullptr) continue;
    append(*list, texts_of(rules[i].publish));
    append(*list, texts_of(rules[i].subscribe));
  }
  if (place.grant().default_allow) lists.allowed_later.emplace_back("*");
  const auto witness = lists.witness(out.effort());
  if (!witness) return;
  auto finding = place.about_rule(
      PERM021, at + 1,
      fmt::format("deny_rule {} lists partitions: Cyclone DDS refuses the topic {} altogether, "
                  "also in partitions that a later rule allows",
                  at + 1, in_quotes(*witness)));
  finding.products = {kCyclone};
  finding.hint =
      "name the partitions that are allowed in an allow_rule, and leave the deny_rule out";
  out.add(std::move(finding));
}

void diagnose_denied_partitions(LintFindings& out, const GrantPlace& place) {
  const auto& rules = place.grant().rules;
  int denials = 0;
  for (std::size_t i = 0; i < rules.size(); ++i) {
    if (rules[i].allow || !lists_partitions(rules[i])) continue;
    if (++denials <= kMaxDenyRules) diagnose_topic_denied_with_partitions(out, place, i);
    auto finding = place.about_rule(
        PERM021, i + 1,
        fmt::format("deny_rule {} lists partitions: Fast DDS denies its topics in all of them",
                    i + 1));
    finding.products = {kFastDds};
    out.add(std::move(finding));
  }
}

void diagnose_default(LintFindings& out, const GrantPlace& place) {
  const auto& grant = place.grant();
  if (grant.default_allow)
    out.add(place.about(PERM022,
                        "<default> is ALLOW: every topic that no rule names is allowed, "
                        "also those that were not thought of"));
  if (std::ranges::any_of(grant.rules, &GrantRule::allow)) return;
  auto finding = place.about(PERM023, "there is no allow_rule");
  finding.products = {kFastDds};
  out.add(std::move(finding));
}

// Returns the domains in which the first rule denies topics and a later rule lets the participant
// join.
std::vector<DomainRange> domains_that_begin_with_denials(const Grant& grant) {
  std::vector<DomainRange> out;
  for (DomainId id = 0; id <= kMaxGovernedDomainId; ++id) {
    const auto is_for = [id](const GrantRule& rule) { return rule.domains.contains(id); };
    const auto first = std::ranges::find_if(grant.rules, is_for);
    if (first == grant.rules.end() || decides_joining(*first)) continue;
    const auto decides = std::find_if(first, grant.rules.end(), [&](const GrantRule& rule) {
      return decides_joining(rule) && is_for(rule);
    });
    if (decides != grant.rules.end() && decides->allow) out.push_back({id, id});
  }
  return joined(std::move(out));
}

void diagnose_joining(LintFindings& out, const GrantPlace& place) {
  if (place.grant().default_allow) return;
  const auto domains = domains_that_begin_with_denials(place.grant());
  if (domains.empty()) return;
  out.add(place.about(
      PERM026, fmt::format("the first rule for domain {} is a deny_rule about topics; ddssec, "
                           "Cyclone DDS and Fast DDS let the participant join by the allow_rule "
                           "after it, a product that takes DDS-Security 1.2 (table 70) "
                           "literally refuses it",
                           to_text(domains))));
}

// Returns the domains that the deny_rule closes to ddssec's plugins, although an allow_rule lets
// the participant join with stock products (doctor: judge_participant_as).
std::vector<DomainRange> closed_by(const Grant& grant, const GrantRule& denial) {
  std::vector<DomainRange> out;
  for (DomainId id = 0; id <= kMaxGovernedDomainId; ++id) {
    const auto decides = std::ranges::find_if(grant.rules, [id](const GrantRule& rule) {
      return decides_joining(rule) && rule.domains.contains(id);
    });
    const bool joins_stock = std::ranges::any_of(grant.rules, [id](const GrantRule& rule) {
      return rule.allow && rule.domains.contains_for_stock(id);
    });
    if (decides != grant.rules.end() && &*decides == &denial && joins_stock)
      out.push_back({id, id});
  }
  return joined(std::move(out));
}

void diagnose_closed_domains(LintFindings& out, const GrantPlace& place) {
  const auto& rules = place.grant().rules;
  int denials = 0;
  for (std::size_t i = 0; i < rules.size(); ++i) {
    if (rules[i].allow || !decides_joining(rules[i]) || ++denials > kMaxDenyRules) continue;
    const auto domains = closed_by(place.grant(), rules[i]);
    if (domains.empty()) continue;
    auto finding = place.about_rule(
        PERM027, i + 1,
        fmt::format("deny_rule {} without topics closes domain {}: ddssec's plugins refuse the "
                    "participant there, Cyclone DDS and Fast DDS let it join by an allow_rule",
                    i + 1, to_text(domains)));
    finding.products = stock_products();
    out.add(std::move(finding));
  }
}

std::vector<DomainRange> uncovered(const GrantRule& rule, const Governance& governance) {
  std::vector<DomainRange> out;
  for (const auto& range : rule.domains.ranges)
    for (auto id = range.first; id <= range.last; ++id)
      if (!governance.find(id)) out.push_back({id, id});
  return joined(std::move(out));
}

void diagnose_domains(LintFindings& out, const GrantPlace& place, const Governance& governance) {
  const auto& rules = place.grant().rules;
  for (std::size_t i = 0; i < rules.size(); ++i) {
    const auto missing = uncovered(rules[i], governance);
    if (!rules[i].allow || missing.empty()) continue;
    out.add(place.about_rule(PERM024, i + 1,
                             fmt::format("allow_rule {} is for domain {}, which no domain_rule of "
                                         "the governance document covers",
                                         i + 1, to_text(missing))));
  }
}

// Returns the domain rule for the first domain of `rule` that the governance document covers, or
// nullptr.
const DomainRule* domain_rule_for(const GrantRule& rule, const Governance& governance) {
  for (const auto& range : rule.domains.ranges)
    for (auto id = range.first; id <= range.last; ++id)
      if (const auto* found = governance.find(id)) return found;
  return nullptr;
}

// The expressions of a domain rule.
class TopicExpressionsOfDomain {
 public:
  explicit TopicExpressionsOfDomain(const DomainRule& rule) {
    for (const auto& topic : rule.topic_rules) {
      texts_.emplace_back(topic.topic_expression);
      patterns_.add(topic.topic_expression);
    }
    patterns_.seal();
  }
  // True if a topic rule may match a name of the expression. Most expressions match as if they were
  // names; the automaton is needed only for the others.
  bool may_match(const std::string& expression, SetEffort& effort) const {
    std::vector<PatternSet::Id> ids;
    if (!patterns_.match(expression, ids, effort.plain_steps) || !ids.empty()) return true;
    const std::string_view own[] = {expression};
    return overlap(own, texts_, kLimits.sharing(effort)).kind != SetAnswer::Kind::no;
  }

 private:
  std::vector<std::string_view> texts_;
  PatternSet patterns_;
};

void diagnose_topic_rules(LintFindings& out, const GrantPlace& place,
                          const Governance& governance) {
  std::map<const DomainRule*, TopicExpressionsOfDomain> known;
  for (const auto& entries : place.actions())
    for (const auto& entry : entries) {
      const auto* domain = entry.rule->allow ? domain_rule_for(*entry.rule, governance) : nullptr;
      if (!domain) continue;
      const auto& rules = known.try_emplace(domain, *domain).first->second;
      if (rules.may_match(entry.topic->text, out.effort())) continue;
      out.add(place.about(
          PERM025, entry,
          fmt::format("{} is allowed, and no topic_rule of the governance document matches it",
                      in_quotes(entry.topic->text))));
    }
}

}  // namespace

void lint_rights(LintFindings& out, const GrantPlace& place, const Governance* governance) {
  diagnose_expressions(out, place);
  diagnose_unread_conditions(out, place);
  for (const auto& entries : place.actions()) {
    diagnose_partitions_by_rule(out, place, entries);
    diagnose_joined_partitions(out, place, entries);
    diagnose_open_denial(out, place, entries);
  }
  diagnose_denials(out, place);
  diagnose_denied_partitions(out, place);
  diagnose_default(out, place);
  diagnose_joining(out, place);
  diagnose_closed_domains(out, place);
  if (!governance) return;
  diagnose_domains(out, place, *governance);
  diagnose_topic_rules(out, place, *governance);
}

}  // namespace ddssec::governance
