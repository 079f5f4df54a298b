// OCSP responses for doctor and check: whether a folder's own can be sent, and whether a
// participant that demands one gets it.
#pragma once

#include <vector>

#include "governance/doctor/meeting.hpp"

namespace ddssec::cli {

/// DOC112, if the folder has a response or a property about them.
void check_ocsp(const governance::doctor::LoadedFolder& folder,
                const governance::doctor::Settings& settings, governance::doctor::Diagnosis& out);

/// DOC113 for each of the two that demands a response of the other, which has none that says
/// "good".
std::vector<Finding> demanded_responses(const governance::doctor::Party& a,
                                        const governance::doctor::Party& b, WallTime now);

}  // namespace ddssec::cli
