// What lint finds in a participant's documents, as part of its diagnosis.
#pragma once

#include "governance/doctor/diagnosis.hpp"

namespace ddssec::governance::doctor {

/// Adds the findings of lint on both documents, as far as they can be read; what a check of `out`
/// was about already is not said again. No verdict changes: what a product refuses is the other
/// checks' to say. To be called after them.
void check_lint(const LoadedFolder& folder, const Settings& settings, Diagnosis& out);

}  // namespace ddssec::governance::doctor
