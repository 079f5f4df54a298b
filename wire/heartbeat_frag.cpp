#include "wire/heartbeat_frag.hpp"

namespace ddssec::rtps {

Result<HeartbeatFrag> read_heartbeat_frag(const SubmessageView& view) {
  auto reader = view.reader();
  HeartbeatFrag out;
  out.reader = DDSSEC_TRY(read_entity_id(reader));
  out.writer = DDSSEC_TRY(read_entity_id(reader));
  out.sequence_number = DDSSEC_TRY(read_sequence_number(reader));
  out.last = FragmentNumber{DDSSEC_TRY(reader.read<std::uint32_t>())};
  out.count = DDSSEC_TRY(reader.read<std::int32_t>());
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
