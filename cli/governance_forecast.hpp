// What running participants do with a changed governance document.
#pragma once

#include "cli/diff_inputs.hpp"
#include "cli/report.hpp"
#include "governance/model.hpp"

namespace ddssec::cli {

/// Adds to the report of a comparison, in text and as `live`, for each host: whether it takes the
/// new document while it runs. Considers every domain, without a tag and with each tag that a
/// document names.
void add_forecast(const governance::Governance& before, const governance::Governance& after,
                  const DiffSides& sides, Report& report);

}  // namespace ddssec::cli
