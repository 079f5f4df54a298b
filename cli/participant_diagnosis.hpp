// All that doctor, check and can know of one participant: its folder, the environment that its
// process would start in, and what ddssec's plugins within Cyclone DDS would refuse.
#pragma once

#include <optional>
#include <string_view>

#include "governance/decision.hpp"
#include "governance/doctor/meeting.hpp"

namespace ddssec::cli {

/// doctor::diagnose, pre-shared keys, limits of keys, CYCLONEDDS_URI, and DOC103.
governance::doctor::Diagnosis diagnosis_of(const governance::doctor::LoadedFolder& folder,
                                           const governance::doctor::Settings& settings);

/// The part that `doctor::meet` does not look at for itself.
governance::doctor::Diagnosis diagnosis_beyond_folder(
    const governance::doctor::LoadedFolder& folder, const governance::doctor::Settings& settings);

/// DOC101, a warning: CYCLONEDDS_URI is not set or empty, and the folder has a cyclonedds.xml. An
/// application that starts here would run without security. It says nothing of the folder itself.
void warn_of_unset_variable(const governance::doctor::LoadedFolder& folder,
                            const governance::doctor::Settings& settings,
                            governance::doctor::Diagnosis& out);

/// True if Cyclone DDS, started for the participant in this environment, would load ddssec's
/// plugins.
bool runs_drop_in(const governance::doctor::LoadedFolder& folder);

/// DOC103: why ddssec's plugins within Cyclone DDS refuse to make a writer (publish) or a reader
/// (subscribe) under this rule. Nothing: they make it. The embedded participant makes it anyway.
std::optional<Finding> refused_by_drop_in(const governance::doctor::LoadedFolder& folder,
                                          const governance::DomainRule& domain,
                                          const governance::TopicRule& rule,
                                          governance::Action action);

}  // namespace ddssec::cli
