// What a DATA carries besides its payload: key hash and status of the instance, and where it stands
// among the changes of its publisher (RTPS 9.6.4, 8.7.5, 8.7.6).
#pragma once

#include <array>
#include <optional>

#include "base/ids.hpp"
#include "wire/content_filter_info.hpp"
#include "wire/numbers.hpp"
#include "wire/time.hpp"

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

/// GroupDigest_t: which writers a publisher has; zero without any.
using GroupDigest = std::array<std::uint8_t, 4>;

/// PRESENTATION's part of a change; 0 everywhere: none, as with SEQUENCENUMBER_UNKNOWN.
struct Coherence {
  SequenceNumber set = {};  ///< COHERENT_SET: of the first change of the writer's set
  SequenceNumber group_set =
      {};                     ///< GROUP_COHERENT_SET: of the first change of the publisher's set
  SequenceNumber group = {};  ///< GROUP_SEQ_NUM: of this change among the publisher's
  GroupDigest writers = {};   ///< WRITER_GROUP_INFO
  bool operator==(const Coherence&) const = default;
};

/// ORIGINAL_WRITER_INFO: the writer of a sample that another one keeps for late joiners
/// (RTPS 8.7.9); number 0: its sender wrote it.
struct Original {
  Guid writer = {};
  SequenceNumber number = {};
  bool operator==(const Original&) const = default;
};

struct InlineQos {
  std::optional<KeyHash> key_hash = {};
  StatusInfo status = {};
  Coherence coherence = {};
  Original original = {};
  /// Where nothing protects INFO_TS, and the submessage is protected: ours only.
  std::optional<Time> source_time = {};
  FilterResults filters = {};  ///< written only
  bool empty() const {
    return !key_hash && status == StatusInfo{} && coherence == Coherence{} &&
           original.number.value == 0 && !source_time && filters.list.empty();
  }
  bool operator==(const InlineQos&) const = default;
};

/// Errors: those of ParameterReader, rtps_parameter_invalid (a value too short),
/// rtps_number_invalid, rtps_parameter_not_understood.
Result<InlineQos> read_inline_qos(BytesView list, Endian endian);
/// With its sentinel.
void write(SpanWriter& out, const InlineQos& qos);

}  // namespace ddssec::rtps
