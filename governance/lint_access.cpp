#include "governance/lint_access.hpp"

#include <algorithm>
#include <utility>

namespace ddssec::governance {
namespace {

using enum Rule;

bool controls_access(const TopicRule& rule) {
  return rule.enable_read_access_control || rule.enable_write_access_control;
}
void diagnose_strangers(LintFindings& out, const DomainPlace& place) {
  const auto& rule = place.rule;
  if (!rule.allow_unauthenticated_participants || !protects_anything(rule)) return;
  if (is_protected(rule.rtps_protection_kind))
    return out.add(place.about(
        GOV022,
        fmt::format(
            "allow_unauthenticated_participants is true and rtps_protection_kind "
            "is {}: strangers can read no message and send none to endpoints of "
            "ddssec; other products take theirs on topics without a protection of their own",
            to_string(rule.rtps_protection_kind))));
  auto finding = place.about(GOV047,
                             "allow_unauthenticated_participants is true beside kinds that "
                             "protect: a stranger's announcement can make "
                             "Cyclone DDS take a participant for an unauthenticated one, so that "
                             "two participants stay apart for good");
  finding.products = {kCyclone};
  out.add(std::move(finding));
}

void diagnose_controls(LintFindings& out, const DomainPlace& place, std::size_t i) {
  const auto& topic = place.rule.topic_rules[i];
  const auto name = in_quotes(topic.topic_expression);
  if (controls_access(topic) && !place.rule.enable_join_access_control)
    out.add(place.about(GOV021, i,
                        fmt::format("{}: access to topics is controlled and joining the domain "
                                    "is not (enable_join_access_control is false)",
                                    name)));
  if (controls_access(topic) && place.rule.allow_unauthenticated_participants) {
    auto finding = place.about(
        GOV025, i, fmt::format("{}: access is controlled and strangers are allowed", name));
    finding.products = stock_products();
    out.add(std::move(finding));
  }
  if (controls_access(topic) && is_plain(topic)) {
    auto finding = place.about(
        GOV043, i,
        fmt::format("{}: access is controlled, and metadata_protection_kind and "
                    "data_protection_kind are NONE, so that only the good will of peers keeps "
                    "them out under Cyclone DDS",
                    name));
    finding.products = {kCyclone};
    out.add(std::move(finding));
  }
}

bool matches_everything(std::string_view expression) {
  return expression.find_first_not_of('*') == expression.npos;
}

// A single open topic may be intended. A rule for all topics also opens topics that its author did
// not think of.
void diagnose_open_topic(LintFindings& out, const DomainPlace& place, std::size_t i) {
  const auto& topic = place.rule.topic_rules[i];
  if (is_protected(place.rule.rtps_protection_kind) || !is_plain(topic) || controls_access(topic))
    return;
  auto finding = place.about(
      GOV040, i,
      fmt::format("{}: every kind that protects samples is NONE: every host on the network can "
                  "read and forge them",
                  in_quotes(topic.topic_expression)));
  if (!matches_everything(topic.topic_expression)) finding.severity = Severity::informational;
  out.add(std::move(finding));
}

// Samples are hidden from participants without the right to read only if they are encrypted with a
// key that only readers get. Reports topics without such a key.
void diagnose_reading(LintFindings& out, const DomainPlace& place, std::size_t i) {
  const auto& topic = place.rule.topic_rules[i];
  const auto name = in_quotes(topic.topic_expression);
  const bool is_secret =
      is_encrypted(topic.data_protection_kind) || is_encrypted(topic.metadata_protection_kind);
  if (is_secret && !topic.enable_read_access_control)
    out.add(place.about(
        GOV041, i,
        fmt::format("{}: the payload is encrypted, and enable_read_access_control is false, so "
                    "that every participant of the domain gets the key",
                    name)));
  if (is_secret || is_plain(topic) || !topic.enable_read_access_control) return;
  const bool is_secret_outside = is_encrypted(place.rule.rtps_protection_kind);
  out.add(place.about(GOV048, i,
                      fmt::format("{}: reading is controlled, and metadata_protection_kind and "
                                  "data_protection_kind encrypt nothing: {} can read the samples",
                                  name,
                                  is_secret_outside ? "each participant that may join"
                                                    : "every host on the network")));
}

void diagnose_writing(LintFindings& out, const DomainPlace& place, std::size_t i) {
  const auto& topic = place.rule.topic_rules[i];
  if (is_plain(topic) || !topic.enable_read_access_control || topic.enable_write_access_control)
    return;
  out.add(place.about(
      GOV049, i,
      fmt::format("{}: enable_write_access_control is false: each participant that may join can "
                  "write, whatever its permissions say",
                  in_quotes(topic.topic_expression))));
}

void diagnose_joining(LintFindings& out, const DomainPlace& place) {
  const auto& rule = place.rule;
  if (rule.enable_join_access_control || !protects_anything(rule) ||
      std::ranges::any_of(rule.topic_rules, controls_access))
    return;
  out.add(place.about(GOV050,
                      "neither joining the domain nor access to any of its topics is controlled: "
                      "each certificate of the identity CA takes part in everything, whatever its "
                      "permissions say"));
}

}  // namespace

bool is_plain(const TopicRule& rule) {
  return !is_protected(rule.metadata_protection_kind) && !is_protected(rule.data_protection_kind);
}

bool protects_anything(const DomainRule& rule) {
  const auto is_protected_topic = [](const TopicRule& topic) {
    return is_protected(topic.metadata_protection_kind) || is_protected(topic.data_protection_kind);
  };
  return is_protected(rule.rtps_protection_kind) || is_protected(rule.discovery_protection_kind) ||
         is_protected(rule.liveliness_protection_kind) ||
         std::ranges::any_of(rule.topic_rules, is_protected_topic);
}

void diagnose_access(LintFindings& out, const DomainPlace& place) {
  const auto& rules = place.rule.topic_rules;
  diagnose_strangers(out, place);
  diagnose_joining(out, place);
  if (!protects_anything(place.rule))
    out.add(place.about(
        GOV040,
        "every protection kind is NONE: every host on the network can read and forge everything"));
  for (std::size_t i = 0; i < rules.size(); ++i) {
    if (protects_anything(place.rule)) diagnose_open_topic(out, place, i);
    diagnose_controls(out, place, i);
    diagnose_reading(out, place, i);
    diagnose_writing(out, place, i);
  }
}

}  // namespace ddssec::governance
