// Pre-shared keys, as doctor and check look at them: whether a folder has the passphrases that its
// governance asks for, and whether those of two folders fit. They are compared here; what is said
// of them is their ids.
#pragma once

#include "governance/doctor/meeting.hpp"

namespace ddssec::cli {

/// DOC091, if the governance asks for pre-shared keys.
void check_pre_shared_keys(const governance::doctor::LoadedFolder& folder,
                           const governance::doctor::Settings& settings,
                           governance::doctor::Diagnosis& out);

/// doctor::meet, and what pre-shared keys and the limits of keys (key_limits.hpp) make of it.
governance::doctor::Meeting meet_with_keys(const governance::doctor::Party& a,
                                           const governance::doctor::Party& b,
                                           const governance::doctor::Settings& settings,
                                           const std::vector<std::string>& topics = {});

}  // namespace ddssec::cli
