// Template governance documents: three named levels of protection.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "governance/model.hpp"

namespace ddssec::governance {

/// The level of protection.
enum class Profile : std::uint8_t {
  open,      ///< nothing: participants without security may join, permissions are not checked
  balanced,  ///< payloads and discovery encrypted, messages signed, permissions enforced
  strict,  ///< like SROS2's template: every layer encrypted, messages signed, permissions enforced
};

/// Returns "open", "balanced" or "strict".
std::string_view to_string(Profile profile);
/// Returns the profile with exactly this name, in lower case; empty if there is none.
std::optional<Profile> profile_from(std::string_view name);

/// Returns the profile's rule for the topics of one expression.
TopicRule topic_rule_of(Profile profile, std::string expression);

/// Returns the profile's domain rule, without topic rules: add at least one.
DomainRule domain_rule_of(Profile profile, std::vector<DomainRange> domains);

/// Returns a whole document: the profile for these domains, with one topic rule `*`. Write it with
/// to_xml(governance).
Governance governance_of(Profile profile, std::vector<DomainRange> domains);

}  // namespace ddssec::governance
