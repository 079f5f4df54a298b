// The report of a comparison of governance documents.
#pragma once

#include "cli/diff/diff_inputs.hpp"
#include "cli/frame/report.hpp"
#include "governance/compare/governance_diff.hpp"

namespace ddssec::cli {

/// Text and JSON of a comparison; does not set the exit code.
/// `only_listed`: the comparison was one of the topics of --topics, and the text says so.
/// `is_phased`: embedded participants take the new document in two phases.
Report report_of(const governance::GovernanceDiff& diff, const DiffSides& sides, bool only_listed,
                 bool is_phased);

}  // namespace ddssec::cli
