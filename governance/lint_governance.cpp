#include <algorithm>

#include <fmt/format.h>

#include "governance/domain_cuts.hpp"
#include "governance/lint.hpp"
#include "governance/lint_access.hpp"
#include "governance/lint_findings.hpp"
#include "governance/live_change.hpp"
#include "governance/pattern.hpp"
#include "governance/shadowed_expressions.hpp"
#include "governance/topic_sets.hpp"

namespace ddssec::governance {
namespace {

using enum Rule;
using Id = Rule;

void add_notes(LintFindings& out, const Governance& document) {
  for (const auto& note : document.notes) {
    switch (note.kind) {
      case NoteKind::order:
        out.add(GOV001, note, {kFastDds});
        break;
      case NoteKind::no_min:
      case NoteKind::no_max:
        out.add(GOV004, note, stock_products());
        break;
      case NoteKind::refused_spelling:
        out.add(GOV023, note, {kFastDds});
        break;
      case NoteKind::padding:
      case NoteKind::refused_padding:
        out.add(GOV005, note, {kFastDds});
        break;
      case NoteKind::byte_order_mark:
      case NoteKind::passed_over:
      case NoteKind::newer_element:
      case NoteKind::default_namespace:
      case NoteKind::other_attribute:
      case NoteKind::no_algorithms:
        out.add(GOV006, note, stock_products());
        break;
      case NoteKind::end_tag_blank:
        out.add(GOV001, note, {kCyclone});
        break;
      case NoteKind::boolean_spelling:
        out.add(GOV023, note, {});
        break;
      case NoteKind::kind_spelling:
        out.add(GOV024, note, stock_products());
        break;
      case NoteKind::accepted_order:
      case NoteKind::no_zone:
      case NoteKind::fraction:
      case NoteKind::no_name:
      case NoteKind::no_default:
      case NoteKind::tag_of_rule:
        break;  // notes of permissions documents
    }
  }
}

bool has_tags(const DomainRule& rule) {
  return !rule.domains.tags.empty() || !rule.domains.tag_expressions.empty();
}

// Domains of the rule for which an earlier rule decides, and the number (from 1) of the first such
// rule.
struct TakenDomains {
  std::vector<DomainRange> domains = {};
  std::vector<DomainRange> by_stock = {};  // domains in which stock products apply the rule
  std::size_t by = 0;
  bool all = true;
};

TakenDomains taken_from(const Governance& document, std::size_t at) {
  TakenDomains out;
  const auto& rule = document.domain_rules[at];
  for (const auto& range : rule.domains.ranges)
    for (auto id = range.first; id <= range.last; ++id) {
      const auto* first = document.find(id);
      if (first == nullptr || first >= &rule) {
        out.all = false;
        continue;
      }
      out.domains.push_back({id, id});
      if (document.find_for_stock(id) == &rule) out.by_stock.push_back({id, id});
      if (out.by == 0) out.by = static_cast<std::size_t>(first - document.domain_rules.data()) + 1;
    }
  out.domains = joined(std::move(out.domains));
  out.by_stock = joined(std::move(out.by_stock));
  return out;
}

void diagnose_coverage(LintFindings& out, const Governance& document, std::size_t at,
                       const DomainPlace& place) {
  if (has_tags(place.rule)) return;
  const auto taken = taken_from(document, at);
  if (taken.domains.empty()) return;
  const auto domains = to_text(taken.domains);
  auto text = taken.all ? fmt::format(
                              "domain_rule {} can never apply: domain {} is covered by "
                              "domain_rule {} already",
                              at + 1, domains, taken.by)
                        : fmt::format(
                              "domain_rule {} does not apply to domain {}: domain_rule {} "
                              "covers it already",
                              at + 1, domains, taken.by);
  if (!taken.by_stock.empty())
    text += fmt::format(
        "; but Cyclone DDS and Fast DDS, which read an <id_range> without <max> as one domain, "
        "apply it to domain {}",
        to_text(taken.by_stock));
  out.add(place.about(GOV002, std::move(text)));
}

std::vector<std::string_view> expressions_of(const DomainRule& rule) {
  std::vector<std::string_view> out;
  for (const auto& topic : rule.topic_rules) out.emplace_back(topic.topic_expression);
  return out;
}

Finding unmatchable(const DomainPlace& place, std::size_t topic) {
  const auto& expression = place.rule.topic_rules[topic].topic_expression;
  auto finding = place.about(
      GOV010, topic,
      fmt::format("topic_rule {} can never apply: {}", topic + 1, matches_nothing(expression)));
  finding.hint = kUnmatchableHint;
  return finding;
}

// The first of the rules in `by` that could never apply if the rule at `at` stood before it.
std::optional<std::uint32_t> dead_if_moved(const DomainRule& rule,
                                           const std::vector<std::uint32_t>& by, std::size_t at,
                                           SetEffort& effort) {
  const std::string_view moved[] = {rule.topic_rules[at].topic_expression};
  for (const auto one : by) {
    const std::string_view earlier[] = {rule.topic_rules[one].topic_expression};
    if (contained(earlier, moved, limits_of_pair(effort)).kind == SetAnswer::Kind::yes) return one;
  }
  return std::nullopt;
}

// A dead rule is harmless if the earlier rules have the same effect.
void diagnose_dead_rules(LintFindings& out, const DomainPlace& place) {
  const auto& rules = place.rule.topic_rules;
  const auto found = shadows(expressions_of(place.rule), out.effort());
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (!found[i].is_dead) continue;
    if (found[i].by.empty()) {
      out.add(unmatchable(place, i));
      continue;
    }
    std::vector<std::string> names;
    for (const auto by : found[i].by)
      names.push_back(fmt::format("{} (rule {})", in_quotes(rules[by].topic_expression), by + 1));
    const bool is_harmless = std::ranges::all_of(
        found[i].by, [&](std::uint32_t by) { return protect_alike(rules[by], rules[i]); });
    auto finding = place.about(
        GOV010, i,
        fmt::format("topic_rule {} {} can never apply: {} already {} every name it matches{}",
                    i + 1, in_quotes(rules[i].topic_expression), fmt::join(names, ", "),
                    names.size() == 1 ? "matches" : "together match",
                    is_harmless ? ", with the same protection" : ""));
    if (is_harmless) finding.severity = Severity::warning;
    if (const auto taken = dead_if_moved(place.rule, found[i].by, i, out.effort()))
      finding.hint = fmt::format(
          "delete it, or rule {} if this one is meant to count: moved before that rule, it would "
          "take all of its names",
          *taken + 1);
    out.add(std::move(finding));
  }
}

void diagnose_topics_without_rule(LintFindings& out, const DomainPlace& place) {
  const auto expressions = expressions_of(place.rule);
  const auto is_everything = [](std::string_view e) { return e.find_first_not_of('*') == e.npos; };
  if (std::ranges::any_of(expressions, is_everything)) return;
  const std::string_view all_names[] = {"?*"};
  const auto answer = contained(all_names, expressions,
                                {.states = 20'000, .steps = 10'000'000, .shared = &out.effort()});
  if (answer.kind == SetAnswer::Kind::yes) return;
  const auto example =
      answer.kind == SetAnswer::Kind::no ? " such as " + in_quotes(answer.witness) : std::string();
  out.add(place.about(
      GOV011, fmt::format("the last topic_rule is not \"*\": topics{} have no rule", example)));
}

void diagnose_domain_kinds(LintFindings& out, const DomainPlace& place) {
  const auto& rule = place.rule;
  for (const auto& [name, kind] :
       {std::pair("discovery_protection_kind", rule.discovery_protection_kind),
        std::pair("liveliness_protection_kind", rule.liveliness_protection_kind),
        std::pair("rtps_protection_kind", rule.rtps_protection_kind)}) {
    if (!is_origin_authenticated(kind)) continue;
    auto finding = place.about(GOV030, fmt::format("{} is {}", name, to_string(kind)));
    finding.products = {kOpenDds, kFastDds};
    out.add(std::move(finding));
  }
}

// Reports flags that demand something that the domain rule does not provide.
void diagnose_flags(LintFindings& out, const DomainPlace& place, std::size_t i) {
  const auto& topic = place.rule.topic_rules[i];
  const auto check = [&](bool flag, ProtectionKind kind, std::string_view what) {
    if (flag && !is_protected(kind))
      out.add(place.about(
          GOV020, i,
          fmt::format("{}: enable_{}_protection is true while {}_protection_kind is NONE",
                      in_quotes(topic.topic_expression), what, what)));
  };
  check(topic.enable_discovery_protection, place.rule.discovery_protection_kind, "discovery");
  check(topic.enable_liveliness_protection, place.rule.liveliness_protection_kind, "liveliness");
}

// Each payload, and each fragment of a sample, is protected on its own. Nothing protects the octets
// around it, except message protection. Every participant gets the message keys and can forge these
// octets with them.
Finding payload_alone(const DomainPlace& place, std::size_t i) {
  const auto& topic = place.rule.topic_rules[i];
  const auto rtps = place.rule.rtps_protection_kind;
  const auto kinds =
      fmt::format("{}: data_protection_kind is {} and metadata_protection_kind is NONE",
                  in_quotes(topic.topic_expression), to_string(topic.data_protection_kind));
  if (is_origin_authenticated(rtps)) {  // each receiver knows the sender of all that it gets
    auto out = place.about(GOV031, i, kinds);
    out.products = stock_products();
    return out;
  }
  return place.about(
      GOV031, i,
      fmt::format("{}: {} can dispose instances in a writer's name, join fragments of different "
                  "samples into one, and make readers skip samples",
                  kinds,
                  is_protected(rtps) ? "each participant that may join, permitted to use the topic "
                                       "or not,"
                                     : "anyone on the network"));
}

void diagnose_kinds(LintFindings& out, const DomainPlace& place, std::size_t i) {
  const auto& topic = place.rule.topic_rules[i];
  const auto name = in_quotes(topic.topic_expression);
  if (is_origin_authenticated(topic.metadata_protection_kind)) {
    auto finding = place.about(GOV030, i,
                               fmt::format("{}: metadata_protection_kind is {}", name,
                                           to_string(topic.metadata_protection_kind)));
    finding.products = {kOpenDds, kFastDds};
    out.add(std::move(finding));
  }
  if (is_protected(topic.data_protection_kind) && !is_protected(topic.metadata_protection_kind))
    out.add(payload_alone(place, i));
}

// All readers of a topic share its writer's key. So each of them can forge messages that the others
// accept as the writer's, unless every reader gets its own MAC (DDS-Security 1.2, clauses 7.1.1.3
// and 10.5.3.3.4).
void diagnose_origin(LintFindings& out, const DomainPlace& place) {
  if (is_origin_authenticated(place.rule.rtps_protection_kind)) return;
  std::vector<std::string> names;
  for (const auto& topic : place.rule.topic_rules)
    if (topic.enable_write_access_control && !is_plain(topic) &&
        !is_origin_authenticated(topic.metadata_protection_kind))
      names.push_back(in_quotes(topic.topic_expression));
  if (names.empty()) return;
  const auto more = names.size() > 3 ? fmt::format(" and {} more", names.size() - 3) : "";
  if (names.size() > 3) names.resize(3);
  out.add(place.about(
      GOV042,
      fmt::format("{}{}: writing is controlled, and each permitted reader has the key to write "
                  "in a writer's name",
                  fmt::join(names, ", "), more)));
}

Finding of_clear_discovery(const DomainPlace& place) {
  const auto& rules = place.rule.topic_rules;
  if (!is_protected(place.rule.discovery_protection_kind))
    return place.about(
        GOV045,
        "discovery_protection_kind is NONE beside other kinds that protect: under Cyclone DDS a "
        "stranger can announce and remove endpoints in the name of any participant, and one "
        "datagram can end the flow of protected samples for good");
  const auto is_closed = &TopicRule::enable_discovery_protection;
  const auto first = std::ranges::find_if_not(rules, is_closed);
  const auto others = std::ranges::count(rules, false, is_closed) - 1;
  return place.about(
      GOV045, static_cast<std::size_t>(first - rules.begin()),
      fmt::format("{}{}: enable_discovery_protection is false, so that clear discovery stays open "
                  "for the whole domain: under Cyclone DDS a stranger can announce and remove "
                  "endpoints of the protected topics, too, in the name of any participant",
                  in_quotes(first->topic_expression),
                  others > 0 ? fmt::format(" and {} more", others) : ""));
}

// Cyclone's core trusts unprotected announcements in the name of every authenticated peer. ddssec's
// plugins stop them only where no honest peer sends any.
void diagnose_clear_discovery(LintFindings& out, const DomainPlace& place) {
  const auto& rules = place.rule.topic_rules;
  const bool is_closed = is_protected(place.rule.discovery_protection_kind) &&
                         std::ranges::all_of(rules, &TopicRule::enable_discovery_protection);
  if (is_closed || !protects_anything(place.rule)) return;
  auto finding = of_clear_discovery(place);
  finding.products = {kCyclone};
  out.add(std::move(finding));
}

// The destination is unprotected in front of a protected submessage, and one key serves all
// receivers. Only a MAC for each of them, or a protected message around both, connects the two.
void diagnose_redirection(LintFindings& out, const DomainPlace& place) {
  const auto& rule = place.rule;
  if (is_protected(rule.rtps_protection_kind)) return;
  const auto is_exposed = [](ProtectionKind kind) {
    return is_protected(kind) && !is_origin_authenticated(kind);
  };
  std::vector<std::string> kinds;
  for (const auto& [name, kind] :
       {std::pair("discovery_protection_kind", rule.discovery_protection_kind),
        std::pair("liveliness_protection_kind", rule.liveliness_protection_kind)})
    if (is_exposed(kind)) kinds.emplace_back(name);
  const auto topic =
      std::ranges::find_if(rule.topic_rules, is_exposed, &TopicRule::metadata_protection_kind);
  if (topic != rule.topic_rules.end())
    kinds.push_back("metadata_protection_kind of " + in_quotes(topic->topic_expression));
  if (kinds.empty()) return;
  out.add(place.about(
      GOV046,
      fmt::format("{} without origin authentication, while rtps_protection_kind is NONE: an "
                  "attacker on the path can send what is meant for one participant to "
                  "another, so that reliable samples, or endpoints, are missed for good",
                  fmt::join(kinds, ", "))));
}

// Like diagnose_origin, for the builtin writers: every participant that may join gets their keys.
void diagnose_builtin_origin(LintFindings& out, const DomainPlace& place) {
  const auto& rule = place.rule;
  if (is_origin_authenticated(rule.rtps_protection_kind)) return;
  std::vector<std::string> kinds;
  for (const auto& [name, kind] :
       {std::pair("discovery_protection_kind", rule.discovery_protection_kind),
        std::pair("liveliness_protection_kind", rule.liveliness_protection_kind)})
    if (is_protected(kind) && !is_origin_authenticated(kind))
      kinds.push_back(fmt::format("{} is {}", name, to_string(kind)));
  if (kinds.empty()) return;
  out.add(place.about(GOV044, fmt::format("{}: each participant that may join has the keys to send "
                                          "such messages in the name of any other",
                                          fmt::join(kinds, " and "))));
}

void diagnose_tags(LintFindings& out, const DomainPlace& place) {
  for (const auto& tag : place.rule.domains.tag_expressions) {
    if (!Pattern(tag.text).matches_no_name()) continue;
    auto finding =
        place.about(GOV010, "a <tag_expression> can never apply: " + matches_nothing(tag.text));
    finding.line = tag.line;
    finding.hint = kUnmatchableHint;
    out.add(std::move(finding));
  }
}

void diagnose_topics(LintFindings& out, const DomainPlace& place) {
  for (std::size_t i = 0; i < place.rule.topic_rules.size(); ++i) {
    const auto& topic = place.rule.topic_rules[i];
    const Text expression{topic.topic_expression, topic.line};
    out.add_if_unportable(GOV012, expression, place.topic_path(i));
    out.add_if_ros_name(GOV013, expression, place.topic_path(i));
    out.add_if_misleading(DOC097, "the topic expression", expression, place.topic_path(i));
    diagnose_flags(out, place, i);
    diagnose_kinds(out, place, i);
  }
}

}  // namespace

std::vector<Finding> lint(const Governance& governance, const GovernanceUse& use) {
  LintFindings out(GOV010);
  add_notes(out, governance);
  for (std::size_t i = 0; i < governance.domain_rules.size(); ++i) {
    const DomainPlace place{governance.domain_rules[i],
                            fmt::format("/dds/domain_access_rules/domain_rule[{}]", i + 1)};
    diagnose_coverage(out, governance, i, place);
    diagnose_tags(out, place);
    diagnose_dead_rules(out, place);
    diagnose_overlaps(out, place);
    diagnose_topics_without_rule(out, place);
    diagnose_domain_kinds(out, place);
    diagnose_access(out, place);
    diagnose_clear_discovery(out, place);
    diagnose_redirection(out, place);
    if (use.choices) {
      diagnose_origin(out, place);
      diagnose_builtin_origin(out, place);
    }
    diagnose_topics(out, place);
  }
  if (use.domain && !governance.find(*use.domain))
    out.add({.rule = GOV003,
             .message = fmt::format("no domain_rule covers domain {}", *use.domain),
             .path = "/dds/domain_access_rules"});
  return out.take();
}

}  // namespace ddssec::governance
