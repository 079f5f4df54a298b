// The header of an RTPS message (RTPS 9.4.4).
#pragma once

#include "base/ids.hpp"
#include "base/submessage_ids.hpp"
#include "wire/span_writer.hpp"
#include "wire/vendor.hpp"

namespace ddssec::rtps {

/// The header at the beginning of a message.
struct Header {
  ProtocolVersion version = kProtocolVersion;
  VendorId vendor = kVendorDdssec;
  GuidPrefix prefix;
  bool operator==(const Header&) const = default;
};

inline constexpr std::size_t kHeaderSize = kRtpsHeaderSize;

/// Errors: rtps_not_a_message (too short, or the first octets are not RTPS),
/// rtps_version_unsupported.
Result<Header> read_header(BytesView message);
void write(SpanWriter& out, const Header& header);

}  // namespace ddssec::rtps
