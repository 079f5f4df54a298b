// Diagnoses one participant for doctor, check and can: its folder, the environment of its process,
// and what ddssec's plugins in Cyclone DDS would refuse.
#pragma once

#include <optional>

#include "governance/decision.hpp"
#include "governance/doctor/meeting.hpp"

namespace ddssec::cli {

/// Returns the result of doctor::diagnose, to which the checks of pre-shared keys, limits of keys,
/// CYCLONEDDS_URI and DOC103 are added.
governance::doctor::Diagnosis diagnosis_of(const governance::doctor::LoadedFolder& folder,
                                           const governance::doctor::Settings& settings);

/// Returns the part of diagnosis_of that `doctor::predict_meeting` does not check itself.
governance::doctor::Diagnosis diagnosis_beyond_folder(
    const governance::doctor::LoadedFolder& folder, const governance::doctor::Settings& settings);

/// Reports DOC101 as a warning if CYCLONEDDS_URI is not set or empty and the folder has a
/// cyclonedds.xml. An application that starts in this environment would run without security. The
/// warning is not about the folder itself.
void warn_of_unset_variable(const governance::doctor::LoadedFolder& folder,
                            const governance::doctor::Settings& settings,
                            governance::doctor::Diagnosis& out);

/// As warn_of_unset_variable, for the variable that names Fast DDS's profiles, and the folder's
/// fastdds.xml.
void warn_of_unset_profiles_file(const governance::doctor::LoadedFolder& folder,
                                 const governance::doctor::Settings& settings,
                                 governance::doctor::Diagnosis& out);

/// True if Cyclone DDS, started for the participant in this environment, would load ddssec's
/// plugins.
bool runs_drop_in(const governance::doctor::LoadedFolder& folder);

/// Returns DOC103 with the reason why ddssec's plugins in Cyclone DDS refuse to create a writer
/// (publish) or a reader (subscribe) with this rule; empty if they do not. The embedded participant
/// creates it anyway.
std::optional<Finding> refused_by_drop_in(const governance::doctor::LoadedFolder& folder,
                                          const governance::DomainRule& domain,
                                          const governance::TopicRule& rule,
                                          governance::Action action);

}  // namespace ddssec::cli
