// Whether ddssec's own plugins start with a folder's security.properties, for doctor and check.
#pragma once

#include "governance/doctor/diagnosis.hpp"

namespace ddssec::cli {

/// Starts the plugins as an embedded participant does, without a socket, and reports their refusal
/// (DOC093). Only for a folder with the file, and with nothing else that keeps them from starting:
/// `before` are the checks besides those of the folder itself.
void check_own_start(const governance::doctor::LoadedFolder& folder,
                     const governance::doctor::Settings& settings,
                     const governance::doctor::Diagnosis& before,
                     governance::doctor::Diagnosis& out);

}  // namespace ddssec::cli
