#include "governance/live_change.hpp"

#include <algorithm>
#include <array>
#include <string>

namespace ddssec::governance {
namespace {

std::string value_text(bool value) { return value ? "true" : "false"; }
std::string value_text(ProtectionKind kind) { return std::string(to_string(kind)); }

std::string value_text(const std::vector<Text>& names) {
  std::string out;
  for (const auto& name : names) out += (out.empty() ? "" : ", ") + name.text;
  return out.empty() ? "not limited" : out;
}

Status differs(std::string_view element, std::string former, std::string next, int line) {
  return fail(Code::governance_renewal_refused, {.line = line,
                                                 .field = std::string(element),
                                                 .expected = std::move(former),
                                                 .found = std::move(next)});
}

template <class GrantRule, class Value>
Status check_same(std::string_view element, const GrantRule& former, const GrantRule& next,
                  Value GrantRule::*value) {
  if (former.*value == next.*value) return {};
  return differs(element, value_text(former.*value), value_text(next.*value), next.line);
}

Status check_algorithms(const DomainRule& former, const DomainRule& next) {
  using Names = std::vector<Text> AllowedAlgorithms::*;
  constexpr std::array<std::pair<std::string_view, Names>, 4> kLists = {{
      {"digital_signature", &AllowedAlgorithms::digital_signature},
      {"digital_signature_identity_trust_chain",
       &AllowedAlgorithms::digital_signature_identity_trust_chain},
      {"key_establishment", &AllowedAlgorithms::key_establishment},
      {"symmetric_cipher", &AllowedAlgorithms::symmetric_cipher},
  }};
  if (former.allowed_algorithms.has_value() != next.allowed_algorithms.has_value())
    return differs("allowed_crypto_algorithms", value_text(former.allowed_algorithms.has_value()),
                   value_text(next.allowed_algorithms.has_value()), next.line);
  if (!former.allowed_algorithms) return {};
  for (const auto& [element, list] : kLists)
    DDSSEC_RETURN_IF_ERROR(
        check_same(element, *former.allowed_algorithms, *next.allowed_algorithms, list));
  return {};
}

Status check_domain(const DomainRule& former, const DomainRule& next) {
  const auto check = [&](std::string_view element, auto value) {
    return check_same(element, former, next, value);
  };
  DDSSEC_RETURN_IF_ERROR(
      check("allow_unauthenticated_participants", &DomainRule::allow_unauthenticated_participants));
  DDSSEC_RETURN_IF_ERROR(
      check("enable_join_access_control", &DomainRule::enable_join_access_control));
  DDSSEC_RETURN_IF_ERROR(check("enable_key_revision", &DomainRule::enable_key_revision));
  DDSSEC_RETURN_IF_ERROR(check("rtps_psk_protection_kind", &DomainRule::rtps_psk_protection_kind));
  return check_algorithms(former, next);
}

Status check_discovery(const DomainRule& former, const TopicRule& added) {
  if (added.enable_discovery_protection || !protects_all_discovery(former)) return {};
  return fail(Code::governance_renewal_refused,
              {.line = added.line,
               .field = "enable_discovery_protection",
               .expected = "true for every topic",
               .found = "false for \"" + added.topic_expression + "\"",
               .note = "participants that run hear no unprotected discovery"});
}

// Returns the rank of the kind: 0 for NONE, 1 for SIGN, 2 for ENCRYPT.
int strength(ProtectionKind kind) { return is_encrypted(kind) ? 2 : is_protected(kind) ? 1 : 0; }

template <class Rule>
Status check_kind(std::string_view element, const Rule& former, const Rule& next,
                  ProtectionKind Rule::*kind) {
  const auto before = former.*kind, after = next.*kind;
  if (strength(before) <= strength(after) &&
      is_origin_authenticated(before) == is_origin_authenticated(after))
    return {};
  return differs(element, value_text(before), value_text(after), next.line);
}

// Adds the kind of the whole domain if it has risen.
Status add_kind(std::string_view element, const DomainRule& former, const DomainRule& next,
                ProtectionKind DomainRule::*kind, LiveChange& out) {
  DDSSEC_RETURN_IF_ERROR(check_kind(element, former, next, kind));
  if (former.*kind != next.*kind)
    out.domain.push_back({element, value_text(former.*kind), value_text(next.*kind), next.line});
  return {};
}

// Participants without authentication take part only where messages are not protected.
Status check_messages(const DomainRule& former, const DomainRule& next) {
  const auto before = former.rtps_protection_kind, after = next.rtps_protection_kind;
  if (is_protected(before) == is_protected(after) || !former.allow_unauthenticated_participants)
    return {};
  return fail(Code::governance_renewal_refused,
              {.line = next.line,
               .field = "rtps_protection_kind",
               .expected = value_text(before),
               .found = value_text(after),
               .note = "unauthenticated participants are allowed, and take part only where "
                       "messages are not protected"});
}

Status add_domain(const DomainRule& former, const DomainRule& next, LiveChange& out) {
  DDSSEC_RETURN_IF_ERROR(check_domain(former, next));
  DDSSEC_RETURN_IF_ERROR(check_messages(former, next));
  DDSSEC_RETURN_IF_ERROR(add_kind("discovery_protection_kind", former, next,
                                  &DomainRule::discovery_protection_kind, out));
  DDSSEC_RETURN_IF_ERROR(add_kind("liveliness_protection_kind", former, next,
                                  &DomainRule::liveliness_protection_kind, out));
  return add_kind("rtps_protection_kind", former, next, &DomainRule::rtps_protection_kind, out);
}

Status check_flag(std::string_view element, const TopicRule& former, const TopicRule& next,
                  bool TopicRule::*flag) {
  if (next.*flag || !(former.*flag)) return {};
  return differs(element, "true", "false", next.line);
}

// Success if receivers can tell the two kinds of data apart, and no key hash is in the clear.
Status check_data(const TopicRule& former, const DomainRule& domain, const TopicRule& next) {
  const auto before = strength(former.data_protection_kind),
             after = strength(next.data_protection_kind);
  const auto change_error = [&](std::string_view element, std::string expected,
                                ProtectionKind found, std::string note) {
    return fail(Code::governance_renewal_refused, {.line = next.line,
                                                   .field = std::string(element),
                                                   .expected = std::move(expected),
                                                   .found = value_text(found),
                                                   .note = std::move(note)});
  };
  if (before == after) return {};
  if (before == 0 && !is_protected(next.metadata_protection_kind))
    return change_error("metadata_protection_kind", "SIGN or ENCRYPT",
                        next.metadata_protection_kind,
                        "data that was not protected can become so while participants run only if "
                        "submessages are protected, too");
  if (after == 2 && !is_encrypted(next.metadata_protection_kind) &&
      !is_encrypted(domain.rtps_protection_kind))
    return change_error("metadata_protection_kind", "ENCRYPT", next.metadata_protection_kind,
                        "data can become encrypted while participants run only if submessages or "
                        "messages are encrypted, too: key hashes stand beside the data");
  return {};
}

// Success if the rule of `next` protects everything that the former one does.
Status check_raised(const TopicRule& former, const DomainRule& domain, const TopicRule& next) {
  DDSSEC_RETURN_IF_ERROR(check_flag("enable_discovery_protection", former, next,
                                    &TopicRule::enable_discovery_protection));
  DDSSEC_RETURN_IF_ERROR(check_flag("enable_liveliness_protection", former, next,
                                    &TopicRule::enable_liveliness_protection));
  DDSSEC_RETURN_IF_ERROR(check_flag("enable_read_access_control", former, next,
                                    &TopicRule::enable_read_access_control));
  DDSSEC_RETURN_IF_ERROR(check_flag("enable_write_access_control", former, next,
                                    &TopicRule::enable_write_access_control));
  DDSSEC_RETURN_IF_ERROR(
      check_kind("metadata_protection_kind", former, next, &TopicRule::metadata_protection_kind));
  DDSSEC_RETURN_IF_ERROR(
      check_kind("data_protection_kind", former, next, &TopicRule::data_protection_kind));
  return check_data(former, domain, next);
}

}  // namespace

bool protects_all_discovery(const DomainRule& rule) {
  return is_protected(rule.discovery_protection_kind) &&
         std::ranges::all_of(rule.topic_rules, &TopicRule::enable_discovery_protection);
}

bool protect_alike(const TopicRule& a, const TopicRule& b) {
  return a.enable_discovery_protection == b.enable_discovery_protection &&
         a.enable_liveliness_protection == b.enable_liveliness_protection &&
         a.enable_read_access_control == b.enable_read_access_control &&
         a.enable_write_access_control == b.enable_write_access_control &&
         a.metadata_protection_kind == b.metadata_protection_kind &&
         a.data_protection_kind == b.data_protection_kind;
}

Status check_topic_change(const TopicRule& former, const DomainRule& domain,
                          const TopicRule& next) {
  return protect_alike(former, next) ? Status() : check_raised(former, domain, next);
}

// A rule of `next` with the awaited expression is taken for the former rule if it fits. If not, it
// is taken for a rule that was added before it. The former rule is then missing at the end, and the
// first misfit is the reason of the error.
Result<LiveChange> live_change(const DomainRule& former, const DomainRule& next) {
  LiveChange out;
  DDSSEC_RETURN_IF_ERROR(add_domain(former, next, out));
  Status misfit;
  auto awaited = former.topic_rules.begin();
  for (const auto& rule : next.topic_rules) {
    if (awaited != former.topic_rules.end() && awaited->topic_expression == rule.topic_expression) {
      const auto fits = check_topic_change(*awaited, next, rule);
      if (fits) {
        if (!protect_alike(*awaited, rule)) out.raised.push_back(&rule);
        ++awaited;
        continue;
      }
      if (misfit) misfit = fits;  // only the first misfit is kept
    }
    DDSSEC_RETURN_IF_ERROR(check_discovery(former, rule));
    out.are_last = out.are_last && awaited == former.topic_rules.end();
    for (auto later = awaited; later != former.topic_rules.end(); ++later) {
      out.fit_in_use = out.fit_in_use && check_topic_change(*later, next, rule);
      out.are_alike = out.are_alike && protect_alike(*later, rule);
    }
    out.rules.push_back(&rule);
  }
  if (awaited == former.topic_rules.end()) return out;
  if (!misfit) return std::unexpected(std::move(misfit).error());
  return fail(Code::governance_renewal_refused,
              {.line = next.line,
               .field = "topic_rule",
               .expected = "the rule for \"" + awaited->topic_expression +
                           "\" with at least its protection, and at its place",
               .found = "another rule or none"});
}

}  // namespace ddssec::governance
