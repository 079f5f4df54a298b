// The key limits in a folder's security.properties, for doctor and check. Without key revision, or
// if malformed, they keep the participant from starting.
#pragma once

#include <optional>

#include "governance/doctor/diagnosis.hpp"

namespace ddssec::cli {

/// The finding DOC093 about wrong limits; empty if they are right or missing.
std::optional<Finding> key_limits_obstacle(const governance::doctor::LoadedFolder& folder,
                                           DomainId domain);

/// The same for a diagnosis, if the file exists.
void check_key_limits(const governance::doctor::LoadedFolder& folder,
                      const governance::doctor::Settings& settings,
                      governance::doctor::Diagnosis& out);

}  // namespace ddssec::cli
