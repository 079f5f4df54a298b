// The source timestamps of a DataWriter's changes (DDS 1.4, 2.2.2.4.2.12 and 2.2.3.17). No I/O,
// clock or lock.
#pragma once

#include <optional>

#include "base/result.hpp"
#include "rtps/qos/qos.hpp"

namespace ddssec::rtps {

/// With DESTINATION_ORDER BY_SOURCE_TIMESTAMP they never go back.
class SourceTimestamps {
 public:
  /// Of the next change: `wanted`, or `now` if the application names none. A calendar that was set
  /// back repeats the last one. Errors: rtps_bad_parameter (`wanted` is before the last one with
  /// BY_SOURCE_TIMESTAMP).
  Result<Time> next(const std::optional<Time>& wanted, Time now, DestinationOrderKind order);
  /// Of a change that the application did not ask for.
  Time not_before_last(Time now) const { return std::max(now, last_); }

 private:
  Time last_{};
};

}  // namespace ddssec::rtps
