// Adds lint of a participant's documents to its diagnosis.
#pragma once

#include "governance/doctor/diagnosis.hpp"

namespace ddssec::governance::doctor {

/// Adds the findings of lint for both documents, as far as they can be read. A finding that repeats
/// a check of `out` is left out. No outcome changes, because the other checks report what a product
/// refuses. Call it after them.
void diagnose_lint(const LoadedFolder& folder, const Settings& settings, Diagnosis& out);

}  // namespace ddssec::governance::doctor
