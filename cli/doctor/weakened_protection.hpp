// Checks for properties of ddssec that reduce protection, for doctor and check.
#pragma once

#include "governance/doctor/diagnosis.hpp"
#include "governance/doctor/loaded_folder.hpp"

namespace ddssec::cli {

/// Reports DOC116 as a warning for each such property. It reads the folder's security.properties,
/// which an embedded participant uses, and the file of DDSSEC_PROPERTIES, which the plugins in
/// Cyclone DDS use. DOC093 reports a file that cannot be read.
void diagnose_weakened_protection(const governance::doctor::LoadedFolder& folder,
                                  governance::doctor::Diagnosis& out);

}  // namespace ddssec::cli
