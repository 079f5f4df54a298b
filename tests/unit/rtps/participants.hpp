// Participants without sockets.
#pragma once

#include <gmock/gmock.h>

#include "wire/span_writer.hpp"

namespace ddssec::rtps::participants {

using testing::message;
using testing::written;

inline Payload payload() { return Payload::copy_of(Bytes{0, 1, 0, 0, 1, 2, 3, 4}); }

inline Bytes announcement(const GuidPrefix& claimed, const GuidPrefix& source) {
  ParticipantData data;
  data.guid = {claimed, kEntityIdParticipant};
  data.metatraffic_unicast = {*Locator::parse("127.0.0.1", 7009)};
  data.builtin_endpoints = builtin_endpoints::kWithoutSecurity;
  std::array<std::uint8_t, 1024> buffer{};
  SpanWriter payload(buffer);
  write_payload(payload, data);
  auto octets = message(
      {written(Data{kSpdpReader, kSpdpWriter, {1}, {}, PayloadKind::data, payload.view()})});
  std::ranges::copy(source.octets, octets.begin() + 8);
  return octets;
}

}  // namespace ddssec::rtps::participants
