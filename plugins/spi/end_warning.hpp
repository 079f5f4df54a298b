// Warnings before a certificate, a revocation list or permissions end.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::spi {

/// The numbers of days before an end at which to warn, the largest first; empty for no warnings.
using WarningDays = std::vector<std::chrono::days>;

/// Returns the value of `org.ddssec.warn_before_end`: up to eight numbers of days from 1 to 3650,
/// separated by commas, or 0 for no warnings. Without the property: 30, 7 and 1. Error:
/// invalid_property.
Result<WarningDays> warning_days(const PropertyList& properties);

/// Tells when a warning about one thing that ends is due. Not thread-safe.
class EndWarning {
 public:
  explicit EndWarning(WarningDays days) : days_(std::move(days)) {}

  /// True once for each of the days before `end`, and again for another `end`. If several days have
  /// passed, only the last one counts. A day in the first two thirds of the time from `begin` to
  /// `end` does not count: a document that is valid for a week is not about to end when it begins.
  /// If no day counts because the validity is so short, a warning is due in its last sixth instead.
  /// False after the end, which has its own error. Needs no memory.
  bool is_due(WallTime begin, WallTime end, WallTime now);

 private:
  WarningDays days_;
  std::optional<WallTime> end_;                ///< the end of the last question
  std::optional<std::chrono::days> last_day_;  ///< the last day for which a warning was due
};

}  // namespace ddssec::spi
