// What a comparison of permissions documents has to say.
#pragma once

#include "cli/diff_inputs.hpp"
#include "cli/report.hpp"
#include "governance/compare/permissions_diff.hpp"

namespace ddssec::cli {

/// Text and JSON of a comparison; the exit code is left alone.
Report report_of(const governance::PermissionsDiff& diff, const DiffSides& sides);

}  // namespace ddssec::cli
