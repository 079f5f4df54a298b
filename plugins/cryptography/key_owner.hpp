// Which endpoint a key belongs to. Cyclone DDS takes a submessage for the words of the endpoint
// that it names if any key of that endpoint's participant opened it. Every participant in the
// domain holds such keys, those of secure discovery among them, so each key is bound to its
// endpoint here.
#pragma once

#include "base/ids.hpp"
#include "base/result.hpp"

namespace ddssec::cryptography {

struct RemoteEndpoint;

/// ParticipantVolatileMessageSecure (DDS-Security 7.4.5): both directions have one key.
inline constexpr EntityId kVolatileWriter{{0xff, 0x02, 0x02, 0xc3}};
inline constexpr EntityId kVolatileReader{{0xff, 0x02, 0x02, 0xc4}};

/// RTPS 9.3.1.2.
constexpr bool is_builtin(const EntityId& id) { return (id.octets[3] & 0xc0) == 0xc0; }

/// Does a submessage, opened by the key of `sender`, name the owner of that key as its sender? A
/// key of unknown owner speaks for an application's endpoints only, or, if received by a builtin
/// endpoint, for builtin ones only. Under a ReadGuard. Errors: submessage_not_of_sender,
/// secure_group_malformed.
Status check_speaker(const RemoteEndpoint& sender, BytesView plain);

}  // namespace ddssec::cryptography
