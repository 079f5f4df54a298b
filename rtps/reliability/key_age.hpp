// How old the keys are that protect a message.
#pragma once

#include <cstdint>

namespace ddssec::rtps {

/// Former keys count for a while after their owner has revised them. Others that should no longer
/// have them may use them until then. Messages without protection count as `newest`. That does not
/// help an attacker: an endpoint takes them only if the governance protects neither messages nor
/// its submessages, and then former keys prove nothing either.
enum class KeyAge : std::uint8_t { newest, former };

/// What happened to the keys of a remote endpoint.
enum class KeyChange : std::uint8_t {
  revised,      ///< keys have come that revise the former ones
  former_ended  ///< the former ones have ended, with which others may have sent in its name
};

}  // namespace ddssec::rtps
