// A fragment of a sample that is larger than readers accept, as a writer of another product may
// send it.
#pragma once

#include "rtps/reliability/stateful_reader.hpp"
#include "rtps/transport/ports.hpp"
#include "rtps/transport/udp_socket.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"
#include "wire/data_frag.hpp"

namespace ddssec::rtps::testing {

constexpr std::uint32_t kOversized = StatefulReader::kMaxSample + 1;

/// Sends it in the writer's name to the first participants of the domain on this machine.
inline void send_oversized(DomainId domain, const Guid& writer, SequenceNumber number) {
  const Bytes part(1000);
  const DataFrag frag{
      kEntityIdUnknown, writer.entity, number, {1}, 1, 1000, kOversized, {}, false, part};
  Bytes buffer(2000);
  SpanWriter out(buffer);
  Header header;
  header.prefix = writer.prefix;
  write(out, header);
  write(out, frag);
  LocatorList to;
  for (int index = 0; index < DomainParticipant::kAnnouncedIndexes; ++index)
    to.push_back(
        *Locator::parse("127.0.0.1", static_cast<std::uint16_t>(ports::user(domain, index))));
  UdpSocket::on_interface(*Locator::parse("127.0.0.1", 0))->send(out.view(), to);
}

/// Returns the event about it, or nullptr.
inline const Event* dropped_event(test::RecordedEvents& events) {
  const std::lock_guard held(events.mutex);
  const auto at = std::ranges::find(events.all, Code::rtps_sample_dropped,
                                    [](const Event& event) { return event.error.code(); });
  return at == events.all.end() ? nullptr : &*at;
}

}  // namespace ddssec::rtps::testing
