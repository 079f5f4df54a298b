#include "wire/nack_frag.hpp"

namespace ddssec::rtps {

Result<NackFrag> read_nack_frag(const SubmessageView& view) {
  auto reader = view.reader();
  NackFrag out;
  DDSSEC_ASSIGN_OR_RETURN(out.reader, read_entity_id(reader));
  DDSSEC_ASSIGN_OR_RETURN(out.writer, read_entity_id(reader));
  DDSSEC_ASSIGN_OR_RETURN(out.sequence_number, read_sequence_number(reader));
  DDSSEC_ASSIGN_OR_RETURN(out.missing, read_fragment_number_set(reader));
  DDSSEC_ASSIGN_OR_RETURN(out.count, reader.read<std::int32_t>());
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
