#include "wire/info_source.hpp"

namespace ddssec::rtps {

Result<InfoSource> read_info_source(const SubmessageView& view) {
  auto reader = view.reader();
  DDSSEC_RETURN_IF_ERROR(reader.skip(4));
  InfoSource info;
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, reader.read_bytes(ProtocolVersion::size));
  info.source.version = ProtocolVersion::from(octets);
  DDSSEC_ASSIGN_OR_RETURN(const auto vendor, reader.read_bytes(VendorId::size));
  info.source.vendor = VendorId::from(vendor);
  DDSSEC_ASSIGN_OR_RETURN(info.source.prefix, read_guid_prefix(reader));
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
