// The limits of the keys' use that a folder's security.properties sets, as doctor and check look at
// them: without key revision, or malformed, they keep the participant from coming up.
#pragma once

#include <optional>

#include "governance/doctor/diagnosis.hpp"

namespace ddssec::cli {

/// DOC093: what is wrong with them; nothing: they are good, or there are none.
std::optional<Finding> key_limits_obstacle(const governance::doctor::LoadedFolder& folder,
                                           DomainId domain);

/// The same for a diagnosis, if there is such a file.
void check_key_limits(const governance::doctor::LoadedFolder& folder,
                      const governance::doctor::Settings& settings,
                      governance::doctor::Diagnosis& out);

}  // namespace ddssec::cli
