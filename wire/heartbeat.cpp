#include "wire/heartbeat.hpp"

namespace ddssec::rtps {
namespace {

constexpr std::uint8_t kHeartbeatFlagFinal = 0x02;
constexpr std::uint8_t kHeartbeatFlagLiveliness = 0x04;
constexpr std::uint8_t kHeartbeatFlagGroup = 0x08;

// Reads the group's fields. The digests are optional: the table in 9.4.5.7 ends with lastGSN, but
// the model in 8.3.8.6 has them.
Result<HeartbeatGroupInfo> read_group(Reader& reader) {
  HeartbeatGroupInfo out;
  DDSSEC_ASSIGN_OR_RETURN(out.current, read_any_sequence_number(reader));
  DDSSEC_ASSIGN_OR_RETURN(out.first, read_sequence_number(reader));
  DDSSEC_ASSIGN_OR_RETURN(out.last, read_any_sequence_number(reader));
  const bool good = out.current.value >= 0 && out.current <= kMaxSequenceNumber &&
                    out.last >= out.first.previous() && out.last <= kMaxSequenceNumber;
  if (!good) return fail(Code::rtps_number_invalid);
  if (reader.remaining() == 0) return out;
  for (auto* digest : {&out.writers, &out.secure_writers}) {
    DDSSEC_ASSIGN_OR_RETURN(const auto octets, reader.read_bytes(digest->size()));
    std::ranges::copy(octets, digest->begin());
  }
  return out;
}

}  // namespace

Result<Heartbeat> read_heartbeat(const SubmessageView& view) {
  auto reader = view.reader();
  Heartbeat out;
  DDSSEC_ASSIGN_OR_RETURN(out.reader, read_entity_id(reader));
  DDSSEC_ASSIGN_OR_RETURN(out.writer, read_entity_id(reader));
  DDSSEC_ASSIGN_OR_RETURN(out.first, read_sequence_number(reader));
  DDSSEC_ASSIGN_OR_RETURN(out.last, read_any_sequence_number(reader));
  DDSSEC_ASSIGN_OR_RETURN(out.count, reader.read<std::int32_t>());
  out.is_final = view.has(kHeartbeatFlagFinal);
  out.asserts_liveliness = view.has(kHeartbeatFlagLiveliness);
  if (out.last < out.first.previous() || out.last > kMaxSequenceNumber)
    return fail(Code::rtps_number_invalid);
  if (view.has(kHeartbeatFlagGroup)) {
    DDSSEC_ASSIGN_OR_RETURN(out.group, read_group(reader));
  }
  return out;
}

void write(SpanWriter& out, const Heartbeat& heartbeat) {
  std::uint8_t flags = heartbeat.is_final ? kHeartbeatFlagFinal : 0;
  if (heartbeat.asserts_liveliness) flags |= kHeartbeatFlagLiveliness;
  if (heartbeat.group) flags |= kHeartbeatFlagGroup;
  const SubmessageScope scope(out, SubmessageId::heartbeat, flags);
  out.write_bytes(heartbeat.reader.view());
  out.write_bytes(heartbeat.writer.view());
  write_sequence_number(out, heartbeat.first);
  write_sequence_number(out, heartbeat.last);
  out.write(heartbeat.count);
  if (!heartbeat.group) return;
  write_sequence_number(out, heartbeat.group->current);
  write_sequence_number(out, heartbeat.group->first);
  write_sequence_number(out, heartbeat.group->last);
  out.write_bytes(heartbeat.group->writers);
  out.write_bytes(heartbeat.group->secure_writers);
}

}  // namespace ddssec::rtps
