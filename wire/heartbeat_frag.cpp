#include "wire/heartbeat_frag.hpp"

namespace ddssec::rtps {

Result<HeartbeatFrag> read_heartbeat_frag(const SubmessageView& view) {
  auto reader = view.reader();
  HeartbeatFrag out;
  DDSSEC_ASSIGN_OR_RETURN(out.reader, read_entity_id(reader));
  DDSSEC_ASSIGN_OR_RETURN(out.writer, read_entity_id(reader));
  DDSSEC_ASSIGN_OR_RETURN(out.sequence_number, read_sequence_number(reader));
  DDSSEC_ASSIGN_OR_RETURN(const auto last, reader.read<std::uint32_t>());
  out.last = FragmentNumber{last};
  DDSSEC_ASSIGN_OR_RETURN(out.count, reader.read<std::int32_t>());
  if (out.last.value == 0) return fail(Code::rtps_number_invalid);
  return out;
}

void write(SpanWriter& out, const HeartbeatFrag& heartbeat) {
  const SubmessageScope scope(out, SubmessageId::heartbeat_frag);
  out.write_bytes(heartbeat.reader.view());
  out.write_bytes(heartbeat.writer.view());
  write_sequence_number(out, heartbeat.sequence_number);
  out.write(heartbeat.last.value);
  out.write(heartbeat.count);
}

}  // namespace ddssec::rtps
