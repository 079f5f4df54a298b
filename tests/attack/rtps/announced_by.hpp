// The announcement that a node sends, as a stranger reads it on the network.
#pragma once

#include <optional>

#include "tests/unit/rtps_security/attacker.hpp"

namespace ddssec::rtps::testing {

/// Returns the announcement of `node`. Nothing arrives meanwhile.
inline ParticipantData announced_by(World& world, const Node& node) {
  std::optional<ParticipantData> out;
  world.filter = [&](const Node& from, Bytes datagram) {
    auto reader = MessageReader::open(datagram);
    while (&from == &node && reader && !out) {
      const auto view = reader->next();
      if (!view || !*view) break;
      if ((*view)->id != SubmessageId::data) continue;
      const auto data = read_data(**view);
      if (data && data->writer == kSpdpWriter) out = read_participant_data(data->payload).value();
    }
    return std::vector<Bytes>{};
  };
  world.run(20);
  world.filter = {};
  return *out;
}

}  // namespace ddssec::rtps::testing
