#include "rtps/dcps/source_timestamps.hpp"

namespace ddssec::rtps {

Result<Time> SourceTimestamps::next(const std::optional<Time>& wanted, Time now,
                                    DestinationOrderKind order) {
  const auto time = wanted.value_or(now);
  if (order == DestinationOrderKind::by_source && time < last_) {
    if (!wanted) return last_;
    return fail(Code::rtps_bad_parameter, {.document = "writer",
                                           .field = "source_timestamp",
                                           .expected = "at least the last one",
                                           .found = "an earlier one"});
  }
  last_ = time;
  return time;
}

}  // namespace ddssec::rtps
