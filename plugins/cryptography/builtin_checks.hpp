// Who is spoken of in what discovery and liveliness say. Cyclone DDS believes a message about any
// participant from any other: one that disposes another's writer ends it.
#pragma once

#include "base/bytes.hpp"
#include "base/ids.hpp"
#include "base/result.hpp"

namespace ddssec::cryptography {

/// Checks a whole submessage, decrypted or from inside of a protected message. DATA and DATA_FRAG
/// of the builtin writers of discovery and liveliness, secure ones or not, may name none but
/// `owner`, wherever they name one: in the parameters and the key of their payload, in the
/// beginning of ParticipantMessageData, and in the key hash of inline QoS. Every other submessage
/// passes after a look at its writer. Nothing is allocated unless it is refused. Of a fragmented
/// sample the first piece must show the name; a second one makes Cyclone DDS refuse the sample.
/// Errors: builtin_source_mismatch, builtin_source_unreadable.
Status check_builtin_source(BytesView submessage, const GuidPrefix& owner);

}  // namespace ddssec::cryptography
