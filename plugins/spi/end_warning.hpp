// Warnings before a certificate, a revocation list or permissions end.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::spi {

/// How many days before an end to warn, the most first; empty: never.
using WarningDays = std::vector<std::chrono::days>;

/// What `org.ddssec.warn_before_end` says: up to eight numbers of days from 1 to 3650, separated by
/// commas, or 0 for no warnings. Without the property: 30, 7 and 1. Error: invalid_property.
Result<WarningDays> warning_days(const PropertyList& properties);

/// Says when a warning about one thing that ends is due. Not thread-safe.
class EndWarning {
 public:
  explicit EndWarning(WarningDays days) : days_(std::move(days)) {}

  /// True once for each of the days before `end`, and again for another `end`. Of several days that
  /// have passed, only the last one counts. A day that lies in the first two thirds of the time
  /// from `begin` to `end` does not count: what is meant to live for a week is not about to end
  /// when it begins. If none counts, the validity is that short: the last sixth of it takes their
  /// place. False after the end, which has its own error. Needs no memory.
  bool is_due(WallTime begin, WallTime end, WallTime now);

 private:
  WarningDays days_;
  std::optional<WallTime> end_;                ///< of what was asked about last
  std::optional<std::chrono::days> last_day_;  ///< for which it was due
};

/// For the "found" of a warning: "2026-12-04T03:00:00Z, in 6 days"; in hours, minutes or seconds if
/// there is no whole day left.
std::string in_time(WallTime end, WallTime now);

}  // namespace ddssec::spi
