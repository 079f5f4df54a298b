#include "wire/acknack.hpp"

namespace ddssec::rtps {
namespace {

constexpr std::uint8_t kFlagFinal = 0x02;

}  // namespace

Result<AckNack> read_acknack(const SubmessageView& view) {
  auto reader = view.reader();
  AckNack out;
  DDSSEC_ASSIGN_OR_RETURN(out.reader, read_entity_id(reader));
  DDSSEC_ASSIGN_OR_RETURN(out.writer, read_entity_id(reader));
  DDSSEC_ASSIGN_OR_RETURN(out.missing, read_sequence_number_set(reader, 0));
  DDSSEC_ASSIGN_OR_RETURN(out.count, reader.read<std::int32_t>());
  out.is_final = view.has(kFlagFinal);
  return out;
}

void write(SpanWriter& out, const AckNack& acknack) {
  const SubmessageScope scope(out, SubmessageId::acknack, acknack.is_final ? kFlagFinal : 0);
  out.write_bytes(acknack.reader.view());
  out.write_bytes(acknack.writer.view());
  write_set(out, acknack.missing);
  out.write(acknack.count);
}

}  // namespace ddssec::rtps
