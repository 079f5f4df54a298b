// Counters of the protocol of a participant.
#pragma once

#include <cstdint>

namespace ddssec::rtps {

/// The numbers of received and of dropped messages; never reset.
struct ParticipantCounters {
  std::uint64_t messages = 0;           ///< datagrams received, also those that were dropped
  std::uint64_t malformed = 0;          ///< messages with a part that could not be read
  std::uint64_t refused_discovery = 0;  ///< announcements that were not trusted or had no room
};

}  // namespace ddssec::rtps
