// What authentication reads in c.pdata: whose participant data it is, and the token in it.
#pragma once

#include <vector>

#include "base/bytes.hpp"
#include "base/ids.hpp"
#include "base/result.hpp"
#include "plugins/spi/symmetric_cipher.hpp"
#include "plugins/spi/udp_address.hpp"

namespace ddssec::authentication {

/// The longest ParticipantBuiltinTopicData in a handshake, in octets.
inline constexpr std::size_t kMostParticipantDataOctets = 64 * 1024;

/// PID_PARTICIPANT_GUID in a big-endian parameter list without encapsulation header. Parameters
/// that we do not know are passed over whatever their number, a missing sentinel is tolerated.
/// Errors: participant_data_malformed, participant_guid_missing.
Result<Guid> participant_guid_in(BytesView participant_data);

/// The ciphers in the IdentityToken of such a list. Of a list without one, or with one that cannot
/// be read, or with two: the standard's. Unlike the token that discovery brings, this one stands
/// under the handshake's signatures.
spi::CipherMask ciphers_in_participant_data(BytesView participant_data);

/// Its PID_BUILTIN_ENDPOINT_SET; 0 if there is none, or one that cannot be read, or two.
std::uint32_t builtin_endpoints_in_participant_data(BytesView participant_data);

/// Its PID_METATRAFFIC_UNICAST_LOCATORs over UDP, at most `kMostAddresses`, none twice. Locators
/// that are no unicast addresses, or cannot be read, are left out.
inline constexpr std::size_t kMostAddresses = 4;
std::vector<spi::UdpAddress> addresses_in_participant_data(BytesView participant_data);

}  // namespace ddssec::authentication
