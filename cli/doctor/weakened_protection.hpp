// Properties of ddssec that take away protection, for doctor and check.
#pragma once

#include "governance/doctor/diagnosis.hpp"
#include "governance/doctor/loaded_folder.hpp"

namespace ddssec::cli {

/// DOC116, a warning, for each such property in the folder's security.properties, which an embedded
/// participant reads, and in the file of DDSSEC_PROPERTIES, which the plugins in Cyclone DDS read.
/// A file that cannot be read is DOC093, not a finding of this check.
void check_weakened_protection(const governance::doctor::LoadedFolder& folder,
                               governance::doctor::Diagnosis& out);

}  // namespace ddssec::cli
