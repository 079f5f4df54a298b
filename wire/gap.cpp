#include "wire/gap.hpp"

namespace ddssec::rtps {
namespace {

constexpr std::uint8_t kFlagGroup = 0x02;

}  // namespace

Result<Gap> read_gap(const SubmessageView& view) {
  auto reader = view.reader();
  Gap out;
  DDSSEC_ASSIGN_OR_RETURN(out.reader, read_entity_id(reader));
  DDSSEC_ASSIGN_OR_RETURN(out.writer, read_entity_id(reader));
  DDSSEC_ASSIGN_OR_RETURN(out.start, read_sequence_number(reader));
  DDSSEC_ASSIGN_OR_RETURN(out.list, read_sequence_number_set(reader, 1));
  if (out.list.base() < out.start) return fail(Code::rtps_number_invalid);
  if (!view.has(kFlagGroup)) return out;
  DDSSEC_ASSIGN_OR_RETURN(const auto first, read_sequence_number(reader));
  DDSSEC_ASSIGN_OR_RETURN(const auto last, read_any_sequence_number(reader));
  if (last < first.previous() || last > kMaxSequenceNumber) return fail(Code::rtps_number_invalid);
  out.group = {first, last};
  return out;
}

void write(SpanWriter& out, const Gap& gap) {
  const SubmessageScope scope(out, SubmessageId::gap, gap.group ? kFlagGroup : 0);
  out.write_bytes(gap.reader.view());
  out.write_bytes(gap.writer.view());
  write_sequence_number(out, gap.start);
  write_set(out, gap.list);
  if (!gap.group) return;
  write_sequence_number(out, gap.group->first);
  write_sequence_number(out, gap.group->second);
}

}  // namespace ddssec::rtps
