// Events about remote participants. Only here is decided whether one counts as about a peer that
// has authenticated; tests/lint/events.py holds the rest of rtps/ to it.
#pragma once

#include <optional>

#include "base/event.hpp"

namespace ddssec::rtps {

/// Who can have sent what an event reports.
enum class Origin : std::uint8_t {
  anyone,   ///< also a stranger, in the peer's name
  its_keys  ///< only the peer: its keys protected it, or it follows from what they did
};

/// `proven_subject`: of the peer's certificate, if the peer authenticated and Origin is its_keys.
/// Without it the event takes a place among those of all strangers (RateLimitedSink), so that no
/// stranger uses up the places of the peer in whose name it sends.
Event peer_event(Error error, std::string guid, std::optional<std::string> proven_subject = {});

}  // namespace ddssec::rtps
