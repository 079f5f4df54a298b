// PublicationBuiltinTopicData and SubscriptionBuiltinTopicData, as announced by SEDP (RTPS
// 8.5.4.4).
#pragma once

#include "rtps/discovery/content_filter_property.hpp"
#include "rtps/discovery/security_parameters.hpp"
#include "rtps/qos/qos.hpp"
#include "rtps/types/type_consistency.hpp"

namespace ddssec::rtps {

/// The announcement of a writer or a reader. The builtin topic and the kind in the GUID show which
/// of them it is.
struct EndpointData {
  Guid guid;
  std::string topic_name = {};
  std::string type_name = {};
  TypeDescription type = {};
  Qos qos = {};
  LocatorList unicast = {}, multicast = {};  ///< empty: those of the participant
  bool expects_inline_qos = false;
  std::optional<Guid> group_guid = {};  ///< of its publisher; sent only with GROUP access
  std::optional<ContentFilterProperty> content_filter = {};  ///< readers only
  std::optional<spi::SecurityInfo> security_info = {};
  std::optional<spi::CipherMask> required_ciphers = {};
  bool by_secure_discovery = false;  ///< true if secure discovery announced a remote endpoint; not
                                     ///< sent
  bool operator==(const EndpointData&) const = default;
};

/// Returns the approximate memory that it uses, in octets.
std::size_t octets_of(const EndpointData& data);

void write_payload(SpanWriter& out, const EndpointData& data);

/// Read an announcement. ENDPOINT_GUID, TOPIC_NAME and TYPE_NAME are required. The GUID must be
/// that of a writer (or reader, respectively), and a PARTICIPANT_GUID must be of the same
/// participant. Absent policies have the defaults of RTPS. Errors: those of read_parameters,
/// rtps_parameter_invalid.
Result<EndpointData> read_publication_data(BytesView payload);
Result<EndpointData> read_subscription_data(BytesView payload);

Result<Guid> read_endpoint_key(BytesView payload);
void write_endpoint_key(SpanWriter& out, const Guid& guid);

}  // namespace ddssec::rtps
