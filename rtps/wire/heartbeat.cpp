#include "rtps/wire/heartbeat.hpp"

namespace ddssec::rtps {
namespace {

constexpr std::uint8_t kFlagFinal = 0x02;
constexpr std::uint8_t kFlagLiveliness = 0x04;

}  // namespace

Result<Heartbeat> read_heartbeat(const SubmessageView& view) {
  auto reader = view.reader();
  Heartbeat out;
  out.reader = DDSSEC_TRY(read_entity_id(reader));
  out.writer = DDSSEC_TRY(read_entity_id(reader));
  out.first = DDSSEC_TRY(read_sequence_number(reader));
  out.last = DDSSEC_TRY(read_any_sequence_number(reader));
  out.count = DDSSEC_TRY(reader.read<std::int32_t>());
  out.is_final = view.has(kFlagFinal);
  out.asserts_liveliness = view.has(kFlagLiveliness);
  if (out.last < out.first.previous() || out.last > kGreatestSequenceNumber)
    return fail(Code::rtps_number_invalid);
  return out;
}

void write(SpanWriter& out, const Heartbeat& heartbeat) {
  std::uint8_t flags = heartbeat.is_final ? kFlagFinal : 0;
  if (heartbeat.asserts_liveliness) flags |= kFlagLiveliness;
  const SubmessageScope scope(out, SubmessageId::heartbeat, flags);
  out.write_bytes(heartbeat.reader.view());
  out.write_bytes(heartbeat.writer.view());
  write_sequence_number(out, heartbeat.first);
  write_sequence_number(out, heartbeat.last);
  out.write(heartbeat.count);
}

}  // namespace ddssec::rtps
