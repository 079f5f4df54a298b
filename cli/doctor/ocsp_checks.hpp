// Checks OCSP responses for doctor and check: whether a folder's own response can be sent, and
// whether a participant that demands a response gets one.
#pragma once

#include <vector>

#include "governance/doctor/meeting.hpp"

namespace ddssec::cli {

/// Reports DOC112 if the folder has a response or a property about responses.
void diagnose_ocsp(const governance::doctor::LoadedFolder& folder,
                   const governance::doctor::Settings& settings,
                   governance::doctor::Diagnosis& out);

/// Returns DOC113 for each participant that demands a response, if the other one has none that says
/// "good".
std::vector<Finding> demanded_responses(const governance::doctor::Party& a,
                                        const governance::doctor::Party& b, WallTime now);

}  // namespace ddssec::cli
