#include "plugins/access_control/protection.hpp"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <string>
#include <vector>

#include "governance/live_change.hpp"

namespace ddssec::access_control {
namespace {

enum class Protects : std::uint8_t { discovery, liveliness, nothing, keys };

struct BuiltinTopicRow {
  std::string_view name;
  Protects by;
};

// The builtin topics (DDS-Security 1.2, clause 7.5.13). The standard uses both names
// DCPSParticipantSecure and DCPSParticipantsSecure. The plain topics carry data that must be
// readable before authentication; no topic rule applies to them.
constexpr auto kBuiltinTopics = std::to_array<BuiltinTopicRow>({
    {"DCPSParticipant", Protects::nothing},
    {"DCPSPublication", Protects::nothing},
    {"DCPSSubscription", Protects::nothing},
    {"DCPSTopic", Protects::nothing},
    {"DCPSParticipantMessage", Protects::nothing},
    {"DCPSTypeLookupRequest", Protects::nothing},
    {"DCPSTypeLookupReply", Protects::nothing},
    {"DCPSParticipantStatelessMessage", Protects::nothing},
    {"DCPSParticipantVolatileMessageSecure", Protects::keys},
    {"DCPSParticipantSecure", Protects::discovery},
    {"DCPSParticipantsSecure", Protects::discovery},
    {"DCPSPublicationsSecure", Protects::discovery},
    {"DCPSSubscriptionsSecure", Protects::discovery},
    {"DCPSParticipantMessageSecure", Protects::liveliness},
});

ProtectionKind kind_of(Protects by, const governance::DomainRule& rule) {
  switch (by) {
    case Protects::discovery:
      return rule.discovery_protection_kind;
    case Protects::liveliness:
      return rule.liveliness_protection_kind;
    case Protects::nothing:
      return ProtectionKind::none;
    case Protects::keys:
      break;
  }
  return ProtectionKind::encrypt;
}

// The names of one algorithm that the plugins may use, in DDS-Security 1.2 and 1.1.
using Names = std::initializer_list<std::string_view>;

std::unexpected<Error> not_enforceable_error(int line, std::string field, std::string expected,
                                             std::string found) {
  return fail(Code::governance_not_enforceable, {.line = line,
                                                 .field = std::move(field),
                                                 .expected = std::move(expected),
                                                 .found = std::move(found)});
}

Status check_listed(int line, std::string_view element, const std::vector<governance::Text>& listed,
                    std::initializer_list<Names> used) {
  for (const auto& names : used) {
    const bool found = std::ranges::any_of(listed, [&](const governance::Text& text) {
      return std::ranges::find(names, text.text) != names.end();
    });
    if (!found) {
      return not_enforceable_error(line, std::string(element), std::string(*names.begin()),
                                   "not listed");
    }
  }
  return {};
}

spi::CipherMask ciphers_in(const std::vector<governance::Text>& names) {
  spi::CipherMask out = 0;
  for (const auto& name : names) out |= spi::cipher_of(name.text).value_or(0);
  return out;
}

Status check_algorithms(const governance::AllowedAlgorithms& allowed) {
  // Local handshakes begin with this key agreement, and key tokens and peers may always use both
  // ciphers. All other algorithms are checked when they are used (allowed_algorithms.hpp).
  DDSSEC_RETURN_IF_ERROR(
      check_listed(allowed.line, "<key_establishment>", allowed.key_establishment,
                   {{"ECDHE-CEUM+P256", "ECDH+prime256v1-CEUM", "ECDH+prime256v1"}}));
  return check_listed(allowed.line, "<symmetric_cipher>", allowed.symmetric_cipher,
                      {{"AES128+GCM"}, {"AES256+GCM"}});
}

}  // namespace

spi::ParticipantSecurityAttributes participant_attributes(const governance::DomainRule& rule) {
  return {.allow_unauthenticated_participants = rule.allow_unauthenticated_participants,
          .is_access_protected = rule.enable_join_access_control,
          .rtps = rule.rtps_protection_kind,
          .discovery = rule.discovery_protection_kind,
          .liveliness = rule.liveliness_protection_kind,
          .rtps_psk = rule.rtps_psk_protection_kind,
          .allowed_ciphers = rule.allowed_algorithms
                                 ? ciphers_in(rule.allowed_algorithms->symmetric_cipher)
                                 : spi::kAllCiphers,
          .is_key_revision_enabled = rule.enable_key_revision,
          .is_all_discovery_protected = governance::protects_all_discovery(rule)};
}

spi::EndpointSecurityAttributes endpoint_attributes(const governance::TopicRule& rule) {
  return {.topic = {.is_read_protected = rule.enable_read_access_control,
                    .is_write_protected = rule.enable_write_access_control,
                    .is_discovery_protected = rule.enable_discovery_protection,
                    .is_liveliness_protected = rule.enable_liveliness_protection},
          .submessage = rule.metadata_protection_kind,
          .payload = rule.data_protection_kind};
}

std::optional<spi::EndpointSecurityAttributes> builtin_attributes(
    const governance::DomainRule& rule, std::string_view topic) {
  const auto row = std::ranges::find(kBuiltinTopics, topic, &BuiltinTopicRow::name);
  if (row == kBuiltinTopics.end()) return std::nullopt;
  spi::EndpointSecurityAttributes attributes;
  attributes.submessage = kind_of(row->by, rule);
  attributes.is_builtin = true;
  return attributes;
}

std::optional<spi::EndpointSecurityAttributes> topic_attributes(
    const governance::CompiledGovernance& rules, std::string_view topic) {
  if (auto builtin = builtin_attributes(rules.domain_rule(), topic)) return builtin;
  const auto* const rule = rules.topic_rule(topic);
  return rule != nullptr ? std::optional(endpoint_attributes(*rule)) : std::nullopt;
}

Status check_enforceable(const governance::DomainRule& rule, const AccessControlOptions& options) {
  if (is_protected(rule.rtps_psk_protection_kind) && !options.host_has_pre_shared_keys) {
    return not_enforceable_error(rule.line, "<rtps_psk_protection_kind>",
                                 "NONE (only embedded participants of ddssec have pre-shared keys)",
                                 std::string(to_string(rule.rtps_psk_protection_kind)));
  }
  if (rule.enable_key_revision && !options.host_revises_keys) {
    return not_enforceable_error(rule.line, "<enable_key_revision>", "false", "true");
  }
  return rule.allowed_algorithms ? check_algorithms(*rule.allowed_algorithms) : Status();
}

}  // namespace ddssec::access_control
