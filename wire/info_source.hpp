// INFO_SRC: the source of the submessages after it (RTPS 9.4.5.11).
#pragma once

#include "wire/header.hpp"
#include "wire/submessage.hpp"

namespace ddssec::rtps {

/// It has the same fields as the header of a message.
struct InfoSource {
  Header source;
  bool operator==(const InfoSource&) const = default;
};

/// Errors: truncated, rtps_version_unsupported.
Result<InfoSource> read_info_source(const SubmessageView& view);
void write(SpanWriter& out, const InfoSource& info);

}  // namespace ddssec::rtps
