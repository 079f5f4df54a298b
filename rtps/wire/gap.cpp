#include "rtps/wire/gap.hpp"

namespace ddssec::rtps {

Result<Gap> read_gap(const SubmessageView& view) {
  auto reader = view.reader();
  Gap out;
  out.reader = DDSSEC_TRY(read_entity_id(reader));
  out.writer = DDSSEC_TRY(read_entity_id(reader));
  out.start = DDSSEC_TRY(read_sequence_number(reader));
  out.list = DDSSEC_TRY(read_sequence_number_set(reader, 1));
  if (out.list.base() < out.start) return fail(Code::rtps_number_invalid);
  return out;
}

void write(SpanWriter& out, const Gap& gap) {
  const SubmessageScope scope(out, SubmessageId::gap);
  out.write_bytes(gap.reader.view());
  out.write_bytes(gap.writer.view());
  write_sequence_number(out, gap.start);
  write_set(out, gap.list);
}

}  // namespace ddssec::rtps
