// What is wrong, dead, weak or unportable in documents that can be read.
#pragma once

#include <optional>
#include <vector>

#include "base/finding.hpp"
#include "governance/model.hpp"
#include "pki/certificate.hpp"

namespace ddssec::governance {

/// The most findings of one rule; the last of them says how many more there are.
inline constexpr std::size_t kMostFindingsPerRule = 20;

/// What a governance document is meant for.
struct GovernanceUse {
  std::optional<DomainId> domain = std::nullopt;
  bool choices = false;  ///< also GOV042 and GOV044, which most documents have for good reasons
};

/// Findings GOV001 to GOV046, by line. Errors stop `governance sign`.
std::vector<Finding> lint(const Governance& governance, const GovernanceUse& use = {});

/// What a permissions document is meant for. What is not given is not looked at.
struct PermissionsUse {
  std::optional<WallTime> now = std::nullopt;
  const pki::Certificate* certificate = nullptr;
  const Governance* governance = nullptr;
  std::size_t signed_octets = 0;  ///< how long the signed document is, or will be at least
};

/// PERM042, of a signed document that is longer than ddssec's plugins take.
Finding too_long_for_peers(std::size_t signed_octets);

/// Findings PERM001 to PERM042 but PERM031, by line. Errors stop `permissions sign`.
std::vector<Finding> lint(const Permissions& permissions, const PermissionsUse& use = {});

/// True if one of them is an error.
bool has_errors(const std::vector<Finding>& findings);

}  // namespace ddssec::governance
