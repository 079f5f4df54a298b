// INFO_REPLY and INFO_REPLY_IP4: where answers should go (RTPS 9.4.5.9, 9.4.5.10). They are checked
// and stepped over: answers go to the locators that discovery gave, which an attacker on the
// path does not choose.
#pragma once

#include "wire/locator.hpp"
#include "wire/submessage.hpp"

namespace ddssec::rtps {

struct InfoReply {
  Locator unicast;  ///< the first of each list, to explain a capture
  Locator multicast;
  bool operator==(const InfoReply&) const = default;
};

/// Errors: truncated, length_out_of_range (more locators than the body holds).
Result<InfoReply> read_info_reply(const SubmessageView& view);
Result<InfoReply> read_info_reply_ip4(const SubmessageView& view);
void write(SpanWriter& out, const InfoReply& info);

}  // namespace ddssec::rtps
