#include "wire/header.hpp"

namespace ddssec::rtps {

Result<Header> read_header(BytesView message) {
  if (message.size() < kHeaderSize || as_text(message.first(4)) != "RTPS")
    return fail(Code::rtps_not_a_message);
  const Header header{ProtocolVersion::from(message.subspan(4)), VendorId::from(message.subspan(6)),
                      GuidPrefix::from(message.subspan(8))};
  if (header.version.octets[0] != 2) return fail(Code::rtps_version_unsupported);
  return header;
}

void write(SpanWriter& out, const Header& header) {
  out.write_bytes(as_bytes("RTPS"));
  out.write_bytes(header.version.view());
  out.write_bytes(header.vendor.view());
  out.write_bytes(header.prefix.view());
}

}  // namespace ddssec::rtps
