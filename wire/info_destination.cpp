#include "wire/info_destination.hpp"

namespace ddssec::rtps {

Result<InfoDestination> read_info_destination(const SubmessageView& view) {
  auto reader = view.reader();
  DDSSEC_ASSIGN_OR_RETURN(const auto guid_prefix, read_guid_prefix(reader));
  return InfoDestination{guid_prefix};
}

void write(SpanWriter& out, const InfoDestination& info) {
  const SubmessageScope scope(out, SubmessageId::info_destination);
  out.write_bytes(info.prefix.view());
}

}  // namespace ddssec::rtps
