// What a DATA carries besides its payload: key hash and status of the instance
// (RTPS 9.6.3.4, 9.6.3.9).
#pragma once

#include <array>
#include <optional>

#include "rtps/wire/content_filter_info.hpp"

namespace ddssec::rtps {

/// KeyHash_t: the big-endian key itself if it can never exceed 16 octets, else its MD5.
using KeyHash = std::array<std::uint8_t, 16>;

/// StatusInfo_t; on the wire always big-endian.
struct StatusInfo {
  bool disposed = false;
  bool unregistered = false;
  /// Alive, but a writer found that the sample does not pass the reader's content filter.
  bool filtered = false;
  bool operator==(const StatusInfo&) const = default;
};

struct InlineQos {
  std::optional<KeyHash> key_hash = {};
  StatusInfo status = {};
  FilterResults filters = {};  ///< written only
  bool empty() const { return !key_hash && status == StatusInfo{} && filters.list.empty(); }
  bool operator==(const InlineQos&) const = default;
};

/// Errors: those of ParameterReader, rtps_parameter_invalid (a key hash or status too short),
/// rtps_parameter_not_understood.
Result<InlineQos> read_inline_qos(BytesView list, Endian endian);
/// With its sentinel.
void write(SpanWriter& out, const InlineQos& qos);

}  // namespace ddssec::rtps
