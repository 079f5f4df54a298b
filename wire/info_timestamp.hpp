// INFO_TS: the source time of the submessages after it (RTPS 9.4.5.12).
#pragma once

#include <optional>

#include "wire/submessage.hpp"
#include "wire/time.hpp"

namespace ddssec::rtps {

/// The source time of the following submessages.
struct InfoTimestamp {
  std::optional<Time> time;  ///< empty if the following submessages have no source time
  bool operator==(const InfoTimestamp&) const = default;
};

/// Errors: truncated.
Result<InfoTimestamp> read_info_timestamp(const SubmessageView& view);
void write(SpanWriter& out, const InfoTimestamp& info);

}  // namespace ddssec::rtps
