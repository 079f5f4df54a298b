// INFO_DST: the participant to which the submessages after it are addressed (RTPS 9.4.5.8).
#pragma once

#include "wire/submessage.hpp"

namespace ddssec::rtps {

/// The participant that the following submessages are for.
struct InfoDestination {
  GuidPrefix prefix;  ///< zero means every participant
  bool operator==(const InfoDestination&) const = default;
};

/// Errors: truncated.
Result<InfoDestination> read_info_destination(const SubmessageView& view);
void write(SpanWriter& out, const InfoDestination& info);

}  // namespace ddssec::rtps
