#include "wire/info_source.hpp"

namespace ddssec::rtps {

Result<InfoSource> read_info_source(const SubmessageView& view) {
  auto reader = view.reader();
  DDSSEC_TRY(reader.skip(4));
  InfoSource info;
  info.source.version = ProtocolVersion::from(DDSSEC_TRY(reader.read_bytes(ProtocolVersion::size)));
  info.source.vendor = VendorId::from(DDSSEC_TRY(reader.read_bytes(VendorId::size)));
  info.source.prefix = DDSSEC_TRY(read_guid_prefix(reader));
  if (info.source.version.octets[0] != 2) return fail(Code::rtps_version_unsupported);
  return info;
}

void write(SpanWriter& out, const InfoSource& info) {
  const SubmessageScope scope(out, SubmessageId::info_source);
  out.write(std::uint32_t{0});
  out.write_bytes(info.source.version.view());
  out.write_bytes(info.source.vendor.view());
  out.write_bytes(info.source.prefix.view());
}

}  // namespace ddssec::rtps
