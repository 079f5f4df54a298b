// PublicationBuiltinTopicData and SubscriptionBuiltinTopicData, as announced by SEDP (RTPS
// 8.5.4.4).
#pragma once

#include <optional>
#include <string>

#include "base/ids.hpp"
#include "plugins/spi/attributes.hpp"
#include "rtps/discovery/content_filter_property.hpp"
#include "rtps/qos/qos.hpp"
#include "rtps/types/type_consistency.hpp"
#include "wire/locator.hpp"

namespace ddssec::rtps {

class SpanWriter;

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
  /// True if secure discovery announced a remote endpoint; not sent.
  bool by_secure_discovery = false;
  bool operator==(const EndpointData&) const = default;
};

/// Returns the approximate memory that it uses, in octets.
std::size_t octets_of(const EndpointData& data);

/// Writes the payload of SEDP's DATA, with encapsulation.
void write_payload(SpanWriter& out, const EndpointData& data);

/// Reads the announcement of a writer. ENDPOINT_GUID, TOPIC_NAME and TYPE_NAME are required. The
/// GUID must be that of a writer, and a PARTICIPANT_GUID must be of the same participant. Absent
/// policies have the defaults of RTPS. Errors: those of open_pl_cdr and read_parameters,
/// rtps_parameter_invalid.
Result<EndpointData> read_publication_data(BytesView payload);
/// Reads the announcement of a reader, by the same rules and with the same errors.
Result<EndpointData> read_subscription_data(BytesView payload);

/// Reads the key alone, which is the payload of a dispose. Errors: those of read_guid_key.
Result<Guid> read_endpoint_key(BytesView payload);
/// Writes the key alone, with encapsulation.
void write_endpoint_key(SpanWriter& out, const Guid& guid);

}  // namespace ddssec::rtps
