// The source timestamps of a DataWriter's changes (DDS 1.4, 2.2.2.4.2.12 and 2.2.3.17). No I/O,
// clock or lock.
#pragma once

#include <algorithm>
#include <optional>

#include "base/result.hpp"
#include "rtps/qos/qos.hpp"

namespace ddssec::rtps {

/// The timestamps of one writer. With DESTINATION_ORDER BY_SOURCE_TIMESTAMP, they never decrease.
class SourceTimestamps {
 public:
  /// Returns the timestamp of the next change: `wanted`, or `now` if the application passes none.
  /// If the system clock was set back, the last timestamp is repeated. Errors: rtps_bad_parameter
  /// (BY_SOURCE_TIMESTAMP, and `wanted` is before the last timestamp).
  Result<Time> next(const std::optional<Time>& wanted, Time now, DestinationOrderKind order);
  /// Returns the timestamp of a change that the application did not request.
  Time not_before_last(Time now) const { return std::max(now, last_); }

 private:
  Time last_{};
};

}  // namespace ddssec::rtps
