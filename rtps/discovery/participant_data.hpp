// ParticipantBuiltinTopicData: what SPDP announces (RTPS 8.5.3.2, DDS-Security 1.2,
// clause 7.5.1.4).
#pragma once

#include <optional>

#include "base/ids.hpp"
#include "base/property.hpp"
#include "plugins/spi/attributes.hpp"
#include "plugins/spi/token.hpp"
#include "wire/locator.hpp"
#include "wire/time.hpp"
#include "wire/vendor.hpp"

namespace ddssec::rtps {

class SpanWriter;

/// The property in a participant's signed data that tells that the participant marks payloads which
/// end an instance (end_mark). It is not announced, because the announcement must stay short.
inline constexpr std::string_view kMarksEndsProperty = "org.ddssec.marks_ends";

/// What a participant announces by SPDP. Unproven, unless it is from the handshake (c.pdata).
struct ParticipantData {
  Guid guid;
  ProtocolVersion version = kProtocolVersion;
  VendorId vendor;
  /// The version that Cyclone DDS announces, for example "0.10.2"; never announced by ddssec.
  std::string vendor_version = {};
  std::optional<std::uint32_t> domain_id = {};
  std::string domain_tag = {};
  std::uint32_t builtin_endpoints = 0;
  Duration lease_duration{{100, 0}};
  LocatorList metatraffic_unicast = {}, metatraffic_multicast = {};
  LocatorList default_unicast = {}, default_multicast = {};
  std::int32_t manual_liveliness_count = 0;
  std::string entity_name = {};
  Bytes user_data = {};
  PropertyList properties = {};
  // Only secured participants announce these:
  std::optional<spi::Token> identity_token = {}, permissions_token = {};
  std::optional<spi::SecurityInfo> security_info = {};
  std::optional<spi::SymmetricCipherInfo> ciphers = {};
  bool operator==(const ParticipantData&) const = default;
};

/// Writes a parameter list without encapsulation, in the writer's byte order. In big-endian it is
/// the handshake's c.pdata (DDS-Security 1.2, clause 10.3.2.5).
void write_parameter_list(SpanWriter& out, const ParticipantData& data);
/// True if the participant is in this domain. Without a domain id in its announcement, the port at
/// which the announcement arrived determines the domain.
bool is_of_domain(const ParticipantData& data, DomainId domain_id, std::string_view domain_tag);
/// Writes the payload of SPDP's DATA, with encapsulation.
void write_payload(SpanWriter& out, const ParticipantData& data);

/// Reads a parameter list without encapsulation. PARTICIPANT_GUID (of a participant) and
/// BUILTIN_ENDPOINT_SET are required. Tokens are read within the limits of spi. Errors: those of
/// read_parameters.
Result<ParticipantData> read_participant_list(BytesView list, Endian endian);
/// Reads the payload of SPDP's DATA, with encapsulation. Errors: those of open_pl_cdr and
/// read_participant_list.
Result<ParticipantData> read_participant_data(BytesView payload);

/// Reads the key alone, which is the payload of a dispose. Errors: those of read_guid_key.
Result<Guid> read_participant_key(BytesView payload);
/// Writes the key alone, with encapsulation.
void write_participant_key(SpanWriter& out, const Guid& guid);

}  // namespace ddssec::rtps
