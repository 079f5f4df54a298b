// Who is spoken of in what discovery and liveliness say. Cyclone DDS believes a message about any
// participant from any other: one that disposes another's writer ends it.
#pragma once

#include "base/bytes.hpp"
#include "base/ids.hpp"
#include "base/result.hpp"
#include "plugins/cryptography/fragment_walks.hpp"

namespace ddssec::cryptography {

/// Checks a whole submessage, decrypted or from inside of a protected message. DATA and DATA_FRAG
/// of the builtin writers of discovery and liveliness, secure ones or not, may name none but
/// `owner`, wherever they name one: in the parameters and the key of their payload, in the
/// beginning of ParticipantMessageData, and in the key hash of inline QoS. What it announces counts
/// (announced_endpoints.hpp). Every other submessage passes after a look at its writer. Returns
/// where the submessage holds the parameter id of type information, of any participant
/// (type_information.hpp). Errors: builtin_source_mismatch, builtin_source_unreadable;
/// builtin_fragment_early of a fragment that must come again.
Result<TypeInformationAt> check_builtin_source(BytesView submessage, const Owner& owner,
                                               DiscoveryOfPeers& peers);

}  // namespace ddssec::cryptography
