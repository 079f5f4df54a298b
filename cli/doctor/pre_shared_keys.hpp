// Checks of pre-shared keys for doctor and check: whether a folder has the passphrases that its
// governance demands, and whether those of two folders match. The passphrases are compared here;
// messages contain only their ids.
#pragma once

#include "governance/doctor/meeting.hpp"

namespace ddssec::cli {

/// Reports DOC091 if the governance document demands pre-shared keys.
void diagnose_pre_shared_keys(const governance::doctor::LoadedFolder& folder,
                              const governance::doctor::Settings& settings,
                              governance::doctor::Diagnosis& out);

/// Returns the result of doctor::predict_meeting, changed by the effects of pre-shared keys, of
/// OCSP responses (ocsp_checks.hpp) and of the properties (own_start.hpp).
governance::doctor::Meeting predict_with_properties(const governance::doctor::Party& a,
                                                    const governance::doctor::Party& b,
                                                    const governance::doctor::Settings& settings,
                                                    const std::vector<std::string>& topics = {});

}  // namespace ddssec::cli
