// A datagram: every submessage is read or refused, and what was read is written and read alike.
// This is linked once for all kinds, and once for each (fuzz_rtps_kind.cpp), where the octets are
// the flags and body of a submessage.
#include <array>
#include <cstdlib>

#include "tests/fuzz/rtps_kind.hpp"
#include "tests/support/written_header_extension.hpp"
#include "wire/acknack.hpp"
#include "wire/data_frag.hpp"
#include "wire/gap.hpp"
#include "wire/heartbeat.hpp"
#include "wire/heartbeat_frag.hpp"
#include "wire/info_destination.hpp"
#include "wire/info_source.hpp"
#include "wire/info_timestamp.hpp"
#include "wire/message_reader.hpp"
#include "wire/nack_frag.hpp"

namespace {

using namespace ddssec;
using namespace ddssec::rtps;

bool same(const Data& a, const Data& b) {
  return a.sequence_number == b.sequence_number && a.inline_qos == b.inline_qos &&
         std::ranges::equal(a.payload,
                            b.payload.first(std::min(a.payload.size(), b.payload.size())));
}
bool same(const DataFrag& a, const DataFrag& b) {
  return a.first == b.first && std::ranges::equal(a.payload, b.payload);
}
bool same(const auto& a, const auto& b) { return a == b; }

void check(const SubmessageView& view, auto read) {
  const auto first = read(view);
  if (!first) return;
  static std::array<std::uint8_t, 1 << 17> buffer;
  SpanWriter out(buffer);
  write(out, *first);
  if (out.overflowed() || out.size() > 0xffff) return;
  const auto again = MessageReader::over_submessages({}, out.view()).next();
  if (!again || !*again) std::abort();
  const auto second = read(**again);
  if (!second || !same(*first, *second)) std::abort();
}

void check(const SubmessageView& view, std::size_t message_size) {
  switch (view.id) {
    case SubmessageId::acknack:
      return check(view, read_acknack);
    case SubmessageId::heartbeat:
      return check(view, read_heartbeat);
    case SubmessageId::gap:
      return check(view, read_gap);
    case SubmessageId::info_timestamp:
      return check(view, read_info_timestamp);
    case SubmessageId::info_source:
      return check(view, read_info_source);
    case SubmessageId::info_destination:
      return check(view, read_info_destination);
    case SubmessageId::nack_frag:
      return check(view, read_nack_frag);
    case SubmessageId::heartbeat_frag:
      return check(view, read_heartbeat_frag);
    case SubmessageId::data:
      return check(view, read_data);
    case SubmessageId::data_frag:
      return check(view, read_data_frag);
    case SubmessageId::header_extension:
      return check(view, [=](const auto& v) { return read_header_extension(v, message_size); });
    default:
      return;
  }
}

// Checks a submessage of that kind with these flags and this body.
void check_one(SubmessageId kind, const std::uint8_t* data, std::size_t size) {
  const auto length = static_cast<std::uint16_t>(size - 1);
  const bool little = (data[0] & 1) != 0;
  const auto low = static_cast<std::uint8_t>(length), high = static_cast<std::uint8_t>(length >> 8);
  Bytes one{static_cast<std::uint8_t>(kind), data[0], little ? low : high, little ? high : low};
  one.insert(one.end(), data + 1, data + size);
  const auto view = MessageReader::over_submessages({}, one).next();
  if (view && *view) check(**view, one.size() + 20);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (const auto kind = ddssec::fuzz::kind()) {
    if (size == 0 || size > 0xffff) return 0;
    check_one(*kind, data, size);
  }
  auto reader = MessageReader::open({data, size});
  if (!reader) return 0;
  for (auto next = reader->next(); next && *next; next = reader->next()) check(**next, size);
  return 0;
}
