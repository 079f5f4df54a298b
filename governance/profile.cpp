#include "governance/profile.hpp"

#include <algorithm>
#include <array>

namespace ddssec::governance {
namespace {

struct Row {
  Profile profile;
  std::string_view name;
  // True if unauthenticated participants are refused, permissions are checked and discovery is
  // protected.
  bool is_closed;
  ProtectionKind discovery, liveliness, rtps, metadata, data;
};

constexpr auto kNone = ProtectionKind::none;
constexpr auto kSign = ProtectionKind::sign;
constexpr auto kEncrypt = ProtectionKind::encrypt;

constexpr std::array<Row, 3> kRows = {{
    {Profile::open, "open", false, kNone, kNone, kNone, kNone, kNone},
    {Profile::balanced, "balanced", true, kEncrypt, kEncrypt, kSign, kNone, kEncrypt},
    {Profile::strict, "strict", true, kEncrypt, kEncrypt, kSign, kEncrypt, kEncrypt},
}};

const Row& row(Profile profile) { return *std::ranges::find(kRows, profile, &Row::profile); }

}  // namespace

std::string_view to_string(Profile profile) { return row(profile).name; }

std::optional<Profile> profile_from(std::string_view name) {
  const auto found = std::ranges::find(kRows, name, &Row::name);
  return found == kRows.end() ? std::nullopt : std::optional(found->profile);
}

TopicRule topic_rule_of(Profile profile, std::string expression) {
  const auto& wanted = row(profile);
  return {.topic_expression = std::move(expression),
          .enable_discovery_protection = wanted.is_closed,
          .enable_liveliness_protection = wanted.is_closed,
          .enable_read_access_control = wanted.is_closed,
          .enable_write_access_control = wanted.is_closed,
          .metadata_protection_kind = wanted.metadata,
          .data_protection_kind = wanted.data};
}

DomainRule domain_rule_of(Profile profile, std::vector<DomainRange> domains) {
  const auto& wanted = row(profile);
  return {.domains = {.ranges = std::move(domains)},
          .allow_unauthenticated_participants = !wanted.is_closed,
          .enable_join_access_control = wanted.is_closed,
          .discovery_protection_kind = wanted.discovery,
          .liveliness_protection_kind = wanted.liveliness,
          .rtps_protection_kind = wanted.rtps};
}

Governance governance_of(Profile profile, std::vector<DomainRange> domains) {
  auto rule = domain_rule_of(profile, std::move(domains));
  rule.topic_rules.push_back(topic_rule_of(profile, "*"));
  Governance out;
  out.domain_rules.push_back(std::move(rule));
  return out;
}

}  // namespace ddssec::governance
