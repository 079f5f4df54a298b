// Binds each key to its endpoint. Cyclone DDS accepts a submessage as coming from the endpoint that
// it names if any key of that endpoint's participant decrypted it. Every participant in the domain
// holds such keys, for example those of secure discovery.
#pragma once

#include "base/ids.hpp"
#include "base/result.hpp"

namespace ddssec::cryptography {

struct RemoteEndpointCrypto;

/// ParticipantVolatileMessageSecure (DDS-Security 1.2, clause 7.5.4). Both directions share one
/// key.
inline constexpr EntityId kVolatileWriter{{0xff, 0x02, 0x02, 0xc3}};
inline constexpr EntityId kVolatileReader{{0xff, 0x02, 0x02, 0xc4}};

/// True for the entity id of a builtin entity (RTPS 9.3.1.2).
constexpr bool is_builtin(const EntityId& id) { return (id.octets[3] & 0xc0) == 0xc0; }

/// Success if a submessage, decrypted with the key of `sender`, names the owner of that key as its
/// sender. A key with an unknown owner may speak only for application endpoints, or, if a builtin
/// endpoint received it, only for builtin ones. Under a ReadGuard. Errors:
/// submessage_not_of_sender, secure_group_malformed.
Status check_speaker(const RemoteEndpointCrypto& sender, BytesView plain);

}  // namespace ddssec::cryptography
