// Creates events about remote participants. Only this file decides whether an event is about an
// authenticated peer; tests/lint/events.py checks that the rest of rtps/ does not.
#pragma once

#include <optional>

#include "base/event.hpp"

namespace ddssec::rtps {

/// The possible senders of the data that an event reports.
enum class EventOrigin : std::uint8_t {
  anyone,   ///< anyone who sends in the peer's name
  its_keys  ///< only the peer: its keys protected the data, or it follows from such data
};

/// Creates an event. `proven_subject` is the subject of the peer's certificate, if the peer
/// authenticated and the origin is its_keys. Without it, the event shares the places of all
/// unauthenticated senders (RateLimitedSink). So an unauthenticated sender cannot use up the places
/// of the peer in whose name it sends.
Event peer_event(Error error, std::string guid, std::optional<std::string> proven_subject = {});

}  // namespace ddssec::rtps
