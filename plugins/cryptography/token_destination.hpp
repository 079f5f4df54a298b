// Checks which participant receives a key token message. Cyclone DDS has one volatile secure writer
// for all peers. It answers the NACK_FRAG of any of them with any message of that writer, and
// leaves the encryption for that peer to the plugin.
#pragma once

#include <optional>

#include "base/bytes.hpp"
#include "base/ids.hpp"
#include "base/result.hpp"
#include "plugins/cryptography/fragmented_tokens.hpp"

namespace ddssec::cryptography {

/// Checks a submessage that the local volatile secure writer is about to send under the key that it
/// shares with one peer. A key token message must name that peer in destination_participant_guid
/// (DDS-Security 1.2, clause 7.3.22): key tokens are never for all participants. Without `receiver`
/// (another vendor's authentication) any destination passes. A fragment that begins the message is
/// recorded in `sent`. A later one passes only if it is recorded there, because it does not name
/// its destination. Other submessages pass.
///
/// Error: token_destination_refused.
Status check_token_destination(BytesView submessage, const std::optional<GuidPrefix>& receiver,
                               FragmentedTokens& sent);

/// Records a DATA_FRAG that is about to be sent to one peer. Other submessages are ignored.
void note_fragment(BytesView submessage, FragmentedTokens& sent);

/// Checks a decrypted submessage from a peer's volatile secure reader. A NACK_FRAG must ask for a
/// message that this peer was sent in fragments. Other submessages pass. Error:
/// token_fragment_not_sent.
Status check_fragment_request(BytesView submessage, const FragmentedTokens& sent);

}  // namespace ddssec::cryptography
