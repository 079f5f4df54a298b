// The values that authentication reads from c.pdata: GUID, identity token, builtin endpoints and
// addresses.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.hpp"
#include "base/ids.hpp"
#include "base/result.hpp"
#include "plugins/spi/symmetric_cipher.hpp"
#include "plugins/spi/udp_address.hpp"

namespace ddssec::authentication {

/// The longest ParticipantBuiltinTopicData in a handshake, in octets.
inline constexpr std::size_t kMaxParticipantDataOctets = 64 * 1024;

/// Returns PID_PARTICIPANT_GUID of a big-endian parameter list without encapsulation header. Any
/// number of unknown parameters is skipped, and a missing sentinel is tolerated. Errors:
/// participant_data_malformed (also if a length is not a multiple of 4), participant_guid_missing.
Result<Guid> participant_guid_in(BytesView participant_data);

/// Returns the ciphers in the IdentityToken of such a list. If the list has no token, two tokens or
/// an unreadable one, these are the standard ciphers. Unlike the token in discovery, this one is
/// covered by the handshake's signatures.
spi::CipherMask ciphers_in_participant_data(BytesView participant_data);

/// Returns PID_BUILTIN_ENDPOINT_SET of such a list; 0 if it is missing, repeated or unreadable.
std::uint32_t builtin_endpoints_in_participant_data(BytesView participant_data);

/// True if such a list has exactly one PID_VENDORID, that of Fast DDS.
bool is_of_fast_dds(BytesView participant_data);

/// The domain in which a participant is. Announcements are not signed, but c.pdata is. Otherwise an
/// attacker could copy the announcement of a participant into another domain.
struct SignedDomain {
  std::optional<std::uint32_t> id;  ///< PID_DOMAIN_ID; empty if it is missing or unreadable
  std::string tag;                  ///< PID_DOMAIN_TAG; empty if it is missing or unreadable
  bool may_lack_tag;                ///< the vendor leaves a tag out
  bool is_ambiguous = false;        ///< one of these parameters comes twice
};
SignedDomain domain_in_participant_data(BytesView participant_data);
/// Success unless the peer's c.pdata names another domain than our own, or two domains. Error:
/// rtps_domain_differs.
Status check_same_domain(const SignedDomain& peer, const SignedDomain& own);

/// PID_METATRAFFIC_UNICAST_LOCATORs over UDP of such a list: at most `kMaxAddresses`, without
/// duplicates. Locators that are unreadable or not unicast are left out.
inline constexpr std::size_t kMaxAddresses = 4;
std::vector<spi::UdpAddress> addresses_in_participant_data(BytesView participant_data);

}  // namespace ddssec::authentication
