// Key derivation: session keys (DDS-Security 1.2, clause 10.5.3.3.3) and the key exchange key
// (clause 10.5.2.1.2).
#pragma once

#include "plugins/cryptography/key_material.hpp"
#include "plugins/spi/shared_secret.hpp"

namespace ddssec::cryptography {

using SessionKey = Secret<struct SessionKeyTag, 32>;
using SessionReceiverKey = Secret<struct SessionReceiverKeyTag, 32>;

/// Returns HMAC-SHA256(sender key, "SessionKey" | salt | session id), cut to the size of the key.
SessionKey derive_session_key(const MasterKey& key, const MasterSalt& salt, SessionId session);

/// Returns the same for a receiver-specific key, with "SessionReceiverKey". `salt` is the sender's.
SessionReceiverKey derive_session_receiver_key(const MasterReceiverKey& key, const MasterSalt& salt,
                                               SessionId session);

/// Returns the key material of the volatile secure endpoints of two participants: AES256-GCM, key
/// id 0.
KeyMaterial derive_key_exchange_material(const spi::SharedSecret& shared);

}  // namespace ddssec::cryptography
