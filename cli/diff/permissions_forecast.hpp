// What running participants do with a changed permissions document.
#pragma once

#include "base/clock.hpp"
#include "cli/diff/diff_inputs.hpp"
#include "cli/frame/report.hpp"
#include "governance/compare/permissions_diff.hpp"
#include "governance/model.hpp"

namespace ddssec::cli {

/// The two documents, what their comparison found, and the time at which they are put into place.
struct PermissionsChangeOver {
  const governance::Permissions& before;
  const governance::Permissions& after;
  const governance::PermissionsDiff& diff;
  WallTime now;
};

/// Adds to the report of a comparison, in text and as `takes_effect`, for each host: whether it
/// takes the new document while it runs. ddssec's plugins refuse one that has no valid grant for
/// their subject, or one that begins earlier than the grant in force (check_follows of
/// plugins/access_control/permissions_holder.hpp).
void add_forecast(const PermissionsChangeOver& change, const DiffSides& sides, Report& report);

}  // namespace ddssec::cli
