// HEADER_EXTENSION of RTPS 2.5 (9.4.5.2): it is read, checked and skipped. No participant of ddssec
// sends one.
#pragma once

#include <optional>

#include "wire/submessage.hpp"
#include "wire/time.hpp"

namespace ddssec::rtps {

/// The parts that are used. Checksums are not verified here.
struct HeaderExtension {
  /// The length of the whole message, including the RTPS header.
  std::optional<std::uint32_t> message_length = {};
  std::optional<Time> send_time = {};
  bool operator==(const HeaderExtension&) const = default;
};

/// `message_size` is the size of the datagram in octets, which a message length must match. Errors:
/// truncated, rtps_submessage_overrun (the lengths differ), those of ParameterReader.
Result<HeaderExtension> read_header_extension(const SubmessageView& view, std::size_t message_size);

}  // namespace ddssec::rtps
