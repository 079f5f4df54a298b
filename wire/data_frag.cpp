#include "wire/data_frag.hpp"

#include <algorithm>

#include "wire/parameter_list.hpp"

namespace ddssec::rtps {
namespace {

constexpr std::uint8_t kFragFlagInlineQos = 0x02;
constexpr std::uint8_t kFragFlagKey = 0x04;
// The octets from the reader id to the sample size. The offset to the inline QoS counts them.
constexpr std::size_t kFragFixedPart = 28;

// Returns the number of octets in fragments first .. first + count - 1. Fails if they are not
// within the sample.
Result<std::size_t> covered_octets(const DataFrag& frag) {
  const std::uint64_t size = frag.fragment_size;
  const std::uint64_t begin = (std::uint64_t{frag.first.value} - 1) * size;
  const std::uint64_t last = std::uint64_t{frag.first.value} + frag.count - 1;
  if (frag.first.value == 0 || frag.count == 0 || size == 0 || last > frag.total())
    return fail(Code::rtps_number_invalid);
  return static_cast<std::size_t>(std::min(frag.count * size, frag.sample_size - begin));
}

Result<std::uint16_t> read_fixed_part(Reader& reader, DataFrag& out) {
  DDSSEC_RETURN_IF_ERROR(reader.skip(2));
  DDSSEC_ASSIGN_OR_RETURN(const auto to_inline_qos, reader.read<std::uint16_t>());
  DDSSEC_ASSIGN_OR_RETURN(out.reader, read_entity_id(reader));
  DDSSEC_ASSIGN_OR_RETURN(out.writer, read_entity_id(reader));
  DDSSEC_ASSIGN_OR_RETURN(out.sequence_number, read_sequence_number(reader));
  DDSSEC_ASSIGN_OR_RETURN(const auto first, reader.read<std::uint32_t>());
  out.first = FragmentNumber{first};
  DDSSEC_ASSIGN_OR_RETURN(out.count, reader.read<std::uint16_t>());
  DDSSEC_ASSIGN_OR_RETURN(out.fragment_size, reader.read<std::uint16_t>());
  DDSSEC_ASSIGN_OR_RETURN(out.sample_size, reader.read<std::uint32_t>());
  return to_inline_qos;
}

}  // namespace

Result<DataFrag> read_data_frag(const SubmessageView& view) {
  auto reader = view.reader();
  DataFrag out;
  DDSSEC_ASSIGN_OR_RETURN(const auto to_inline_qos, read_fixed_part(reader, out));
  DDSSEC_ASSIGN_OR_RETURN(const auto covered, covered_octets(out));
  if (to_inline_qos < kFragFixedPart || to_inline_qos - kFragFixedPart > reader.remaining())
    return fail(Code::rtps_submessage_overrun);
  DDSSEC_RETURN_IF_ERROR(reader.skip(to_inline_qos - kFragFixedPart));
  if (view.has(kFragFlagInlineQos)) {
    DDSSEC_ASSIGN_OR_RETURN(const auto list, parameter_list_prefix(reader.rest(), view.endian()));
    DDSSEC_ASSIGN_OR_RETURN(out.inline_qos, read_inline_qos(list, view.endian()));
    DDSSEC_RETURN_IF_ERROR(reader.skip(list.size()));
  }
  out.is_key = view.has(kFragFlagKey);
  out.encoded = reader.rest();
  DDSSEC_ASSIGN_OR_RETURN(out.payload, reader.read_bytes(covered));
  return out;
}

Result<DataFrag> with_payload(DataFrag frag, BytesView plain) {
  DDSSEC_ASSIGN_OR_RETURN(const auto covered, covered_octets(frag));
  if (plain.size() < covered) return fail(Code::truncated);
  frag.payload = plain.first(covered);
  return frag;
}

void write(SpanWriter& out, const DataFrag& data) {
  std::uint8_t flags = data.inline_qos.empty() ? 0 : kFragFlagInlineQos;
  if (data.is_key) flags |= kFragFlagKey;
  const SubmessageScope scope(out, SubmessageId::data_frag, flags);
  out.write(std::uint16_t{0});
  out.write(static_cast<std::uint16_t>(kFragFixedPart));
  out.write_bytes(data.reader.view());
  out.write_bytes(data.writer.view());
  write_sequence_number(out, data.sequence_number);
  out.write(data.first.value);
  out.write(data.count);
  out.write(data.fragment_size);
  out.write(data.sample_size);
  if (!data.inline_qos.empty()) write(out, data.inline_qos);
  out.write_bytes(data.payload);
}

}  // namespace ddssec::rtps
