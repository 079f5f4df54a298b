// The one thing authentication reads in c.pdata: whose participant data it is.
#pragma once

#include "base/bytes.hpp"
#include "base/ids.hpp"
#include "base/result.hpp"

namespace ddssec::authentication {

/// The longest ParticipantBuiltinTopicData in a handshake, in octets.
inline constexpr std::size_t kMostParticipantDataOctets = 64 * 1024;

/// PID_PARTICIPANT_GUID in a big-endian parameter list without encapsulation header. Parameters
/// that we do not know are passed over whatever their number, a missing sentinel is tolerated.
/// Errors: participant_data_malformed, participant_guid_missing.
Result<Guid> participant_guid_in(BytesView participant_data);

}  // namespace ddssec::authentication
