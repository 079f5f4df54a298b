// HEADER_EXTENSION of RTPS 2.5 (9.4.5.2): read, checked and stepped over; never sent.
#pragma once

#include <optional>

#include "wire/submessage.hpp"
#include "wire/time.hpp"

namespace ddssec::rtps {

/// The parts that can be used; checksums are not verified here.
struct HeaderExtension {
  std::optional<std::uint32_t> message_length = {};  ///< whole message, RTPS header included
  std::optional<Time> send_time = {};
  bool operator==(const HeaderExtension&) const = default;
};

/// `message_size`: octets of the datagram; a stated length must be the same. Errors: truncated,
/// rtps_submessage_overrun (another length), those of ParameterReader.
Result<HeaderExtension> read_header_extension(const SubmessageView& view, std::size_t message_size);
void write(SpanWriter& out, const HeaderExtension& extension);

}  // namespace ddssec::rtps
