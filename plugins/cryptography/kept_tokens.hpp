// What becomes of a peer's key tokens (9.5.2.2) in a host that asks no plugin about their source.
#pragma once

#include "plugins/cryptography/engine.hpp"

namespace ddssec::cryptography {

/// Key tokens in a decoded `submessage` stay in the ledger, and the host gets tickets. What it must
/// not see now comes to it as a message of a class that it does not know: one that is missing would
/// hold up all that follow. Submessages without key tokens stay as they are. `pair` is that of the
/// sender's participant and ours.
Status keep_tokens(Shared& shared, const RemoteEndpoint& sender, const Pair& pair,
                   MutableBytes submessage);

/// Of a `submessage` that the host sends by our volatile writer: key tokens of an endpoint of ours
/// for one of the peer. The host has matched the two, and now waits for the peer's tokens. Noted
/// for a peer with our plugins only: another would not notice that we begin the session anew.
void note_own_tokens(const Shared& shared, const LocalEndpoint& sender, const Pair& pair,
                     BytesView submessage);

}  // namespace ddssec::cryptography
