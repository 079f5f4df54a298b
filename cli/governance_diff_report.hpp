// What a comparison of governance documents has to say.
#pragma once

#include "cli/diff_inputs.hpp"
#include "cli/report.hpp"
#include "governance/compare/governance_diff.hpp"

namespace ddssec::cli {

/// Text and JSON of a comparison; the exit code is left alone.
Report report_of(const governance::GovernanceDiff& diff, const DiffSides& sides);

}  // namespace ddssec::cli
