// The report of a comparison of permissions documents.
#pragma once

#include "cli/diff/diff_inputs.hpp"
#include "cli/frame/report.hpp"
#include "governance/compare/permissions_diff.hpp"

namespace ddssec::cli {

/// Text and JSON of a comparison; does not set the exit code.
Report report_of(const governance::PermissionsDiff& diff, const DiffSides& sides);

}  // namespace ddssec::cli
