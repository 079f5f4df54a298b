// Publication- and SubscriptionBuiltinTopicData: what SEDP announces (RTPS 8.5.4.4).
#pragma once

#include "rtps/discovery/content_filter_property.hpp"
#include "rtps/discovery/security_parameters.hpp"
#include "rtps/qos/qos.hpp"
#include "rtps/types/type_consistency.hpp"

namespace ddssec::rtps {

/// A writer's or a reader's announcement; which, the topic and the GUID's kind say.
struct EndpointData {
  Guid guid;
  std::string topic_name = {};
  std::string type_name = {};
  TypeDescription type = {};
  Qos qos = {};
  LocatorList unicast = {}, multicast = {};  ///< empty: the participant's defaults
  bool expects_inline_qos = false;
  std::optional<Guid> group_guid = {};  ///< its publisher's; sent with GROUP access only
  std::optional<ContentFilterProperty> content_filter = {};  ///< a reader's
  std::optional<spi::SecurityInfo> security_info = {};
  std::optional<spi::CipherMask> required_ciphers = {};
  bool by_secure_discovery = false;  ///< how a remote one was announced; not part of what is sent
  bool operator==(const EndpointData&) const = default;
};

/// About what it takes in memory.
std::size_t octets_of(const EndpointData& data);

void write_payload(SpanWriter& out, const EndpointData& data);

/// ENDPOINT_GUID, TOPIC_NAME and TYPE_NAME must be there, the GUID must be a writer's (a reader's),
/// and a PARTICIPANT_GUID must be of the same participant. Absent policies take the defaults of
/// RTPS. Errors: those of read_parameters, rtps_parameter_invalid.
Result<EndpointData> read_publication_data(BytesView payload);
Result<EndpointData> read_subscription_data(BytesView payload);

Result<Guid> read_endpoint_key(BytesView payload);
void write_endpoint_key(SpanWriter& out, const Guid& guid);

}  // namespace ddssec::rtps
