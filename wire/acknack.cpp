#include "wire/acknack.hpp"

namespace ddssec::rtps {
namespace {

constexpr std::uint8_t kFlagFinal = 0x02;

}  // namespace

Result<AckNack> read_acknack(const SubmessageView& view) {
  auto reader = view.reader();
  AckNack out;
  out.reader = DDSSEC_TRY(read_entity_id(reader));
  out.writer = DDSSEC_TRY(read_entity_id(reader));
  out.missing = DDSSEC_TRY(read_sequence_number_set(reader, 0));
  out.count = DDSSEC_TRY(reader.read<std::int32_t>());
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
