// ParticipantBuiltinTopicData: what SPDP announces (RTPS 8.5.3.2, DDS-Security 7.4.1.4).
#pragma once

#include <optional>

#include "base/ids.hpp"
#include "plugins/spi/attributes.hpp"
#include "plugins/spi/token.hpp"
#include "rtps/discovery/parameter_table.hpp"
#include "wire/time.hpp"
#include "wire/vendor.hpp"

namespace ddssec::rtps {

struct ParticipantData {
  Guid guid;
  ProtocolVersion version = kProtocolVersion;
  VendorId vendor;
  std::string vendor_version = {};  ///< what Cyclone DDS says of itself: "0.10.2"; never announced
  std::optional<std::uint32_t> domain_id = {};
  std::string domain_tag = {};
  std::uint32_t builtin_endpoints = 0;
  Duration lease_duration{{100, 0}};
  LocatorList metatraffic_unicast = {}, metatraffic_multicast = {};
  LocatorList default_unicast = {}, default_multicast = {};
  std::int32_t manual_liveliness_count = 0;
  std::string entity_name = {};
  Bytes user_data = {};
  spi::PropertyList properties = {};
  // A secured participant's.
  std::optional<spi::Token> identity_token = {}, permissions_token = {};
  std::optional<spi::SecurityInfo> security_info = {};
  std::optional<spi::SymmetricCipherInfo> ciphers = {};
  bool operator==(const ParticipantData&) const = default;
};

/// A parameter list without encapsulation, in the writer's byte order. In big-endian it is the
/// handshake's c.pdata (DDS-Security 9.3.2.5).
void write_parameter_list(SpanWriter& out, const ParticipantData& data);
/// Is it of this domain? One that does not say so is of the domain by whose port it came.
bool is_of_domain(const ParticipantData& data, DomainId domain_id, std::string_view domain_tag);
/// With encapsulation: the payload of SPDP's DATA.
void write_payload(SpanWriter& out, const ParticipantData& data);

/// PARTICIPANT_GUID (of a participant) and BUILTIN_ENDPOINT_SET must be there; tokens are read
/// within spi's bounds. Errors: those of read_parameters.
Result<ParticipantData> read_participant_list(BytesView list, Endian endian);
Result<ParticipantData> read_participant_data(BytesView payload);

/// The key alone: the payload of a dispose. Errors: as above.
Result<Guid> read_participant_key(BytesView payload);
void write_participant_key(SpanWriter& out, const Guid& guid);

}  // namespace ddssec::rtps
