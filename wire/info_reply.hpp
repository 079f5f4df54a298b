// INFO_REPLY and INFO_REPLY_IP4: the locators to which answers should be sent (RTPS 9.4.5.9,
// 9.4.5.10). They are checked and skipped. Answers go to the locators from discovery, which an
// attacker on the network path does not choose.
#pragma once

#include "wire/locator.hpp"
#include "wire/submessage.hpp"

namespace ddssec::rtps {

/// What is kept of the submessage.
struct InfoReply {
  /// The first locator of each list, which is used only to explain a capture.
  Locator unicast;
  Locator multicast;
  bool operator==(const InfoReply&) const = default;
};

/// Errors: truncated, length_out_of_range (more locators than the body can contain).
Result<InfoReply> read_info_reply(const SubmessageView& view);
Result<InfoReply> read_info_reply_ip4(const SubmessageView& view);
void write(SpanWriter& out, const InfoReply& info);

}  // namespace ddssec::rtps
