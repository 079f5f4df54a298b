// Walks the submessages of a received message in place.
#pragma once

#include <optional>

#include "wire/header.hpp"
#include "wire/submessage.hpp"

namespace ddssec::rtps {

/// Borrows the message. A broken submessage header ends the walk: what came before it counts
/// (RTPS 8.3.4.1), nothing behind it can be trusted.
class MessageReader {
 public:
  static Result<MessageReader> open(BytesView message);
  /// Over a plain sequence of submessages, as inside a protected message.
  static MessageReader over_submessages(const Header& header, BytesView submessages) {
    return {header, submessages};
  }

  const Header& header() const { return header_; }
  /// The next submessage, or nothing at the end. Errors: truncated, rtps_submessage_overrun.
  Result<std::optional<SubmessageView>> next();
  /// Everything not yet walked over.
  BytesView rest() const { return rest_; }

 private:
  MessageReader(const Header& header, BytesView rest) : header_(header), rest_(rest) {}

  Header header_;
  BytesView rest_;
};

}  // namespace ddssec::rtps
