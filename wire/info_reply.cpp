#include "wire/info_reply.hpp"

namespace ddssec::rtps {
namespace {

constexpr std::uint8_t kFlagMulticast = 0x02;

Result<Locator> read_list(Reader& reader) {
  DDSSEC_ASSIGN_OR_RETURN(const auto count, reader.read_count(kLocatorSize));
  if (count == 0) return Locator{};
  DDSSEC_ASSIGN_OR_RETURN(const auto first, read_locator(reader));
  DDSSEC_RETURN_IF_ERROR(reader.skip((count - 1) * kLocatorSize));
  return first.kind == LocatorKind::invalid ? Locator{} : first;
}

void write_list(SpanWriter& out, const Locator& locator) {
  const bool any = locator.kind != LocatorKind::invalid;
  out.write(std::uint32_t{any});
  if (any) write_locator(out, locator);
}

// Reads a LocatorUDPv4: the address as one number in the submessage's byte order, then the port.
Result<Locator> read_ip4(Reader& reader) {
  DDSSEC_ASSIGN_OR_RETURN(const auto address, reader.read<std::uint32_t>());
  DDSSEC_ASSIGN_OR_RETURN(const auto port, reader.read<std::uint32_t>());
  Locator out{LocatorKind::udp_v4, port, {}};
  for (unsigned i = 0; i < 4; ++i)
    out.address[12 + i] = static_cast<std::uint8_t>(address >> (24 - 8 * i));
  return out;
}

}  // namespace

Result<InfoReply> read_info_reply(const SubmessageView& view) {
  auto reader = view.reader();
  InfoReply info;
  DDSSEC_ASSIGN_OR_RETURN(info.unicast, read_list(reader));
  if (view.has(kFlagMulticast)) {
    DDSSEC_ASSIGN_OR_RETURN(info.multicast, read_list(reader));
  }
  return info;
}

Result<InfoReply> read_info_reply_ip4(const SubmessageView& view) {
  auto reader = view.reader();
  InfoReply info;
  DDSSEC_ASSIGN_OR_RETURN(info.unicast, read_ip4(reader));
  if (view.has(kFlagMulticast)) {
    DDSSEC_ASSIGN_OR_RETURN(info.multicast, read_ip4(reader));
  }
  return info;
}

void write(SpanWriter& out, const InfoReply& info) {
  const bool multicast = info.multicast.kind != LocatorKind::invalid;
  const SubmessageScope scope(out, SubmessageId::info_reply, multicast ? kFlagMulticast : 0);
  write_list(out, info.unicast);
  if (multicast) write_list(out, info.multicast);
}

}  // namespace ddssec::rtps
