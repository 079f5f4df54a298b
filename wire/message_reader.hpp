// Iterates over the submessages of a received message in place.
#pragma once

#include <optional>

#include "wire/header.hpp"
#include "wire/submessage.hpp"

namespace ddssec::rtps {

/// Borrows the message. An invalid submessage header ends the iteration: the submessages before it
/// are valid (RTPS 8.3.4.1), but nothing after it can be trusted.
class MessageReader {
 public:
  /// Reads the message header. Errors: those of read_header.
  static Result<MessageReader> open(BytesView message);
  /// Iterates over submessages without a message header, such as those inside a protected message.
  static MessageReader over_submessages(const Header& header, BytesView submessages) {
    return {header, submessages};
  }

  const Header& header() const { return header_; }
  /// Returns the next submessage, or empty at the end. Errors: truncated, rtps_submessage_overrun.
  Result<std::optional<SubmessageView>> next();
  /// Returns the rest of the message, after the submessages returned so far.
  BytesView rest() const { return rest_; }

 private:
  MessageReader(const Header& header, BytesView rest) : header_(header), rest_(rest) {}

  Header header_;
  BytesView rest_;
};

}  // namespace ddssec::rtps
