// Finds errors, dead rules, weaknesses and portability problems in documents that can be parsed.
#pragma once

#include <optional>
#include <vector>

#include "base/finding.hpp"
#include "governance/model.hpp"
#include "pki/certificate.hpp"

namespace ddssec::governance {

/// The largest number of findings for one rule; the last of them gives the number of those left
/// out.
inline constexpr std::size_t kMaxFindingsPerRule = 20;

/// The intended use of a governance document.
struct GovernanceUse {
  std::optional<DomainId> domain = std::nullopt;
  bool choices = false;  ///< also GOV042 and GOV044, which most documents have for good reasons
};

/// Returns the findings about a governance document (GOV...), by line. Errors stop `governance
/// sign`.
std::vector<Finding> lint(const Governance& governance, const GovernanceUse& use = {});

/// The intended use of a permissions document. Checks for values that are not given are skipped.
struct PermissionsUse {
  std::optional<WallTime> now = std::nullopt;
  const pki::Certificate* certificate = nullptr;
  const Governance* governance = nullptr;
  std::size_t signed_octets = 0;  ///< length of the signed document, or a lower bound of it
};

/// Returns the finding PERM042, for a signed document that is longer than ddssec's plugins accept.
Finding too_long_for_peers(std::size_t signed_octets);

/// Returns the findings about a permissions document (PERM... except PERM031), by line. Errors stop
/// `permissions sign`.
std::vector<Finding> lint(const Permissions& permissions, const PermissionsUse& use = {});

/// True if one of them is an error.
bool has_errors(const std::vector<Finding>& findings);

}  // namespace ddssec::governance
