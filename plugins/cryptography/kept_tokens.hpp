// Handles a peer's key tokens (DDS-Security 1.2, clause 10.5.2.1) for a host that does not ask the
// plugins about their source.
#pragma once

#include "plugins/cryptography/cryptography_state.hpp"

namespace ddssec::cryptography {

/// Keeps the key tokens of a decoded `submessage` in the ledger and gives tickets to the host. A
/// message that the host must not see is passed to it under a class that it does not know, because
/// a missing message would delay all that follow. Submessages without key tokens stay unchanged.
/// `pair` belongs to the sender's participant and the local one. Errors: those of read_data_piece,
/// read_token_message; crypto_tokens_repeated, crypto_tokens_early (not accepted now, will be sent
/// again).
///
/// Nothing is accepted before the local volatile reader has sent a submessage to the peer. Until
/// Cyclone DDS has connected this reader, it passes a message on by the readers of its other
/// participants. The sender repeats the message, and then this reader passes it on, too. The host
/// would store the same ticket twice and so corrupt its memory. A reader sends only when it is
/// connected.
Status keep_tokens(CryptographyState& state, const RemoteEndpointCrypto& sender,
                   const ParticipantPair& pair, MutableBytes submessage);

/// Inspects a `submessage` that the host sends with the local volatile writer, for key tokens of a
/// local endpoint for one of the peer. The host has matched the two, and now waits for the peer's
/// tokens. This is recorded only for a peer with ddssec: other plugins would not notice that the
/// session is restarted.
void note_own_tokens(const CryptographyState& state, const LocalEndpointCrypto& sender,
                     const ParticipantPair& pair, BytesView submessage);

}  // namespace ddssec::cryptography
