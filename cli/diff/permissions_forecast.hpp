// Predicts what running participants do with a changed permissions document.
#pragma once

#include "base/clock.hpp"
#include "cli/diff/diff_inputs.hpp"
#include "cli/frame/report.hpp"
#include "governance/compare/permissions_diff.hpp"
#include "governance/model.hpp"

namespace ddssec::cli {

/// The two documents, the result of their comparison, and the time at which the new one is put into
/// place.
struct PermissionsChangeOver {
  const governance::Permissions& before;
  const governance::Permissions& after;
  const governance::PermissionsDiff& diff;
  WallTime now;
};

/// The outcome for each host: whether it accepts the new document while it runs.
struct PermissionsForecast {
  std::string_view embedded, cyclonedds_ddssec, cyclonedds, fastdds;
  std::string reason;
  std::optional<std::string> at;
  std::string text = {};  ///< complete lines

  static constexpr auto fields() {
    using T = PermissionsForecast;
    constexpr FieldOptions kOurs{.def = "taken_permissions"},
        kInCyclone{.def = "taken_permissions_in_cyclonedds"}, kStock{.words = "same|restart"};
    return std::tuple(field<&T::embedded>(kOurs), field<&T::cyclonedds_ddssec>(kInCyclone),
                      field<&T::cyclonedds>(kStock), field<&T::fastdds>(kStock),
                      field<&T::reason>(), field<&T::at>());
  }
};

/// Predicts the outcomes. ddssec's plugins refuse a document that has no valid grant for their
/// subject, or one that begins or was signed earlier than the one in force (check_follows of
/// plugins/access_control/permissions_holder.hpp).
PermissionsForecast forecast_of(const PermissionsChangeOver& change, const DiffSides& sides);

}  // namespace ddssec::cli
