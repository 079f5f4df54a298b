// Checks which participant the messages of discovery and liveliness concern. Cyclone DDS accepts a
// message about any participant from any other: a message that disposes another participant's
// writer ends that writer.
#pragma once

#include "base/bytes.hpp"
#include "base/ids.hpp"
#include "base/result.hpp"
#include "plugins/cryptography/fragment_walks.hpp"

namespace ddssec::cryptography {

/// Checks a whole submessage, decrypted or inside a protected message.
///
/// DATA and DATA_FRAG of the builtin writers of discovery and liveliness, secure or not, may name
/// only `owner`. This covers every place that names a participant: the parameters and the key of
/// the payload, the beginning of ParticipantMessageData, and the key hash of inline QoS. What such
/// a sample announces is counted (announced_endpoints.hpp). A sample of any other writer passes
/// unless its inline QoS would end the host (is_deprecated_address). Other submessages pass.
///
/// Returns the position of the parameter id of type information, of any participant
/// (type_information.hpp). Errors: builtin_source_mismatch, builtin_source_unreadable,
/// inline_qos_refused; builtin_fragment_early for a fragment that must come again, and
/// announcements_delayed for an announcement that must (discovery_work.hpp).
Result<TypeInformationAt> check_builtin_source(BytesView submessage, const Owner& owner,
                                               DiscoveryOfPeers& peers);

}  // namespace ddssec::cryptography
