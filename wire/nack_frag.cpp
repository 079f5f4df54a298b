#include "wire/nack_frag.hpp"

namespace ddssec::rtps {

Result<NackFrag> read_nack_frag(const SubmessageView& view) {
  auto reader = view.reader();
  NackFrag out;
  out.reader = DDSSEC_TRY(read_entity_id(reader));
  out.writer = DDSSEC_TRY(read_entity_id(reader));
  out.sequence_number = DDSSEC_TRY(read_sequence_number(reader));
  out.missing = DDSSEC_TRY(read_fragment_number_set(reader));
  out.count = DDSSEC_TRY(reader.read<std::int32_t>());
  return out;
}

void write(SpanWriter& out, const NackFrag& nack) {
  const SubmessageScope scope(out, SubmessageId::nack_frag);
  out.write_bytes(nack.reader.view());
  out.write_bytes(nack.writer.view());
  write_sequence_number(out, nack.sequence_number);
  write_set(out, nack.missing);
  out.write(nack.count);
}

}  // namespace ddssec::rtps
