// Checks whether ddssec's own plugins start with the given properties, for doctor and check.
#pragma once

#include "governance/doctor/diagnosis.hpp"

namespace ddssec::cli {

/// Starts the plugins as an embedded participant does, without a socket, and reports their refusal
/// (DOC093). This is done only for a folder with security.properties, and only if nothing else
/// prevents the start: `before` are the checks besides those of the folder itself.
void diagnose_own_start(const governance::doctor::LoadedFolder& folder,
                        const governance::doctor::Settings& settings,
                        const governance::doctor::Diagnosis& before,
                        governance::doctor::Diagnosis& out);

/// Starts the plugins as a Cyclone DDS process does, and reports their refusal (DOC093): with the
/// values of its configuration, and with the properties of DDSSEC_PROPERTIES and
/// DDSSEC_SYMMETRIC_CIPHER_ALGORITHM. If the process would not load ddssec's plugins (`is_in_use`
/// is false), a refusal is only a warning.
void diagnose_start_in_cyclonedds(const governance::doctor::LoadedFolder& folder,
                                  const governance::doctor::Settings& settings, bool is_in_use,
                                  const governance::doctor::Diagnosis& before,
                                  governance::doctor::Diagnosis& out);

}  // namespace ddssec::cli
