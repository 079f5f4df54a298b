#include "wire/data.hpp"

#include "wire/parameter_list.hpp"

namespace ddssec::rtps {
namespace {

constexpr std::uint8_t kFlagInlineQos = 0x02;
constexpr std::uint8_t kFlagData = 0x04;
constexpr std::uint8_t kFlagKey = 0x08;
// The octets from the reader id to the sequence number. The offset to the inline QoS counts them.
constexpr std::size_t kFixedPart = 16;

Result<PayloadKind> payload_kind(const SubmessageView& view) {
  if (view.has(kFlagData) && view.has(kFlagKey)) return fail(Code::malformed);
  if (view.has(kFlagData)) return PayloadKind::data;
  return view.has(kFlagKey) ? PayloadKind::key : PayloadKind::none;
}

std::uint8_t flags_of(const Data& data) {
  std::uint8_t flags = data.inline_qos.empty() ? 0 : kFlagInlineQos;
  if (data.kind == PayloadKind::data) flags |= kFlagData;
  if (data.kind == PayloadKind::key) flags |= kFlagKey;
  return flags;
}

}  // namespace

Result<Data> read_data(const SubmessageView& view) {
  auto reader = view.reader();
  Data out;
  DDSSEC_ASSIGN_OR_RETURN(out.kind, payload_kind(view));
  DDSSEC_RETURN_IF_ERROR(reader.skip(2));
  DDSSEC_ASSIGN_OR_RETURN(const auto to_inline_qos, reader.read<std::uint16_t>());
  DDSSEC_ASSIGN_OR_RETURN(out.reader, read_entity_id(reader));
  DDSSEC_ASSIGN_OR_RETURN(out.writer, read_entity_id(reader));
  DDSSEC_ASSIGN_OR_RETURN(out.sequence_number, read_sequence_number(reader));
  if (to_inline_qos < kFixedPart || to_inline_qos - kFixedPart > reader.remaining())
    return fail(Code::rtps_submessage_overrun);
  DDSSEC_RETURN_IF_ERROR(reader.skip(to_inline_qos - kFixedPart));
  if (view.has(kFlagInlineQos)) {
    DDSSEC_ASSIGN_OR_RETURN(const auto list, parameter_list_prefix(reader.rest(), view.endian()));
    DDSSEC_ASSIGN_OR_RETURN(out.inline_qos, read_inline_qos(list, view.endian()));
    DDSSEC_RETURN_IF_ERROR(reader.skip(list.size()));
  }
  if (out.kind != PayloadKind::none) out.payload = reader.rest();
  return out;
}

void write(SpanWriter& out, const Data& data) {
  const SubmessageScope scope(out, SubmessageId::data, flags_of(data));
  out.write(std::uint16_t{0});
  out.write(static_cast<std::uint16_t>(kFixedPart));
  out.write_bytes(data.reader.view());
  out.write_bytes(data.writer.view());
  write_sequence_number(out, data.sequence_number);
  if (!data.inline_qos.empty()) write(out, data.inline_qos);
  out.write_bytes(data.payload);
}

}  // namespace ddssec::rtps
