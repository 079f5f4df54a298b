// Packs submessages into messages and hands these to a transport.
#pragma once

#include <array>
#include <span>

#include "rtps/transport/transport.hpp"
#include "rtps/wire/header.hpp"
#include "rtps/wire/info_destination.hpp"
#include "rtps/wire/info_timestamp.hpp"

namespace ddssec::rtps {

/// Whom a submessage is for.
struct Destination {
  GuidPrefix prefix = {};                  ///< zero: everybody at the locators
  std::span<const Locator> locators = {};  ///< borrowed until the flush
};

/// Submessages for the same locators share a message until it is full or flushed. Nothing is
/// allocated: the buffer is part of the object. Not thread-safe.
class MessageSender {
 public:
  /// As Cyclone DDS: fits two jumbo frames; larger samples go in fragments.
  static constexpr std::size_t kLargestMessage = 14720;

  MessageSender(Transport& transport, const GuidPrefix& prefix);

  template <class S>
  void add(const Destination& to, const S& submessage) {
    begin(to);
    const auto before = out_.size();
    write(out_, submessage);
    if (!out_.overflowed()) return;
    out_.rewind(before);
    flush();
    begin(to);
    write(out_, submessage);
  }
  /// The time of the submessages behind it, in this message only.
  template <class S>
  void add(const Destination& to, const InfoTimestamp& time, const S& submessage) {
    begin(to);
    const auto before = out_.size();
    write(out_, time);
    write(out_, submessage);
    if (!out_.overflowed()) return;
    out_.rewind(before);
    flush();
    begin(to);
    write(out_, time);
    write(out_, submessage);
  }
  void flush();

 private:
  void begin(const Destination& to);

  Transport& transport_;
  Header header_;
  std::array<std::uint8_t, kLargestMessage> buffer_{};
  SpanWriter out_;
  Destination to_;
};

}  // namespace ddssec::rtps
