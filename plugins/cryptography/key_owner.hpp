// Binds each key to its endpoint. Cyclone DDS accepts a submessage as coming from the endpoint that
// it names if any key of that endpoint's participant decrypted it. Every participant in the domain
// holds such keys, for example those of secure discovery.
#pragma once

#include "base/ids.hpp"
#include "base/result.hpp"

namespace ddssec::cryptography {

struct RemoteEndpointCrypto;

/// Success if a submessage, decrypted with the key of `sender`, names the owner of that key as its
/// sender. A key with an unknown owner may speak only for application endpoints, or, if a builtin
/// endpoint received it, only for builtin ones. Under a ReadGuard. Errors:
/// submessage_not_of_sender, secure_group_malformed.
Status check_speaker(const RemoteEndpointCrypto& sender, BytesView plain);

}  // namespace ddssec::cryptography
