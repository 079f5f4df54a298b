// The parameters that a DATA carries besides its payload: the key hash and status of the instance,
// and its position among the changes of its publisher (RTPS 9.6.4, 8.7.5, 8.7.6).
#pragma once

#include <array>
#include <optional>

#include "base/ids.hpp"
#include "wire/content_filter_info.hpp"
#include "wire/memory_reference.hpp"
#include "wire/numbers.hpp"
#include "wire/time.hpp"

namespace ddssec::rtps {

/// KeyHash_t: the big-endian key itself if it can never exceed 16 octets, otherwise its MD5.
using KeyHash = std::array<std::uint8_t, 16>;

/// StatusInfo_t; always big-endian on the wire.
struct StatusInfo {
  bool disposed = false;
  bool unregistered = false;
  /// True if the instance is alive, but the writer found that the sample does not pass the reader's
  /// content filter.
  bool filtered = false;
  bool operator==(const StatusInfo&) const = default;
};

/// GroupDigest_t: digest of the writers of a publisher. Zero if there are none.
using GroupDigest = std::array<std::uint8_t, 4>;

/// The fields of a change for PRESENTATION. A field of 0 is absent, as with SEQUENCENUMBER_UNKNOWN.
struct CoherentSetInfo {
  /// COHERENT_SET: the number of the first change of the writer's set.
  SequenceNumber set = {};
  /// GROUP_COHERENT_SET: the number of the first change of the publisher's set.
  SequenceNumber group_set = {};
  /// GROUP_SEQ_NUM: the number of this change among those of the publisher.
  SequenceNumber group = {};
  GroupDigest writers = {};  ///< WRITER_GROUP_INFO
  bool operator==(const CoherentSetInfo&) const = default;
};

/// ORIGINAL_WRITER_INFO: the writer of a sample that a durability service sends to late joiners
/// (RTPS 8.7.9). If the number is 0, the sender itself wrote the sample.
struct OriginalWriterInfo {
  Guid writer = {};
  SequenceNumber number = {};
  bool operator==(const OriginalWriterInfo&) const = default;
};

/// The parameters of a change that are sent with it (RTPS 9.6.4). Others are skipped, or
/// refused if they must be understood.
struct InlineQos {
  std::optional<KeyHash> key_hash = {};
  StatusInfo status = {};
  CoherentSetInfo coherence = {};
  OriginalWriterInfo original = {};
  /// The source time, for a protected submessage whose INFO_TS is not protected. Specific to
  /// ddssec.
  std::optional<Time> source_time = {};
  /// Written only, never read: a list with results is unequal to what is read from its octets.
  FilterResults filters = {};
  /// The place of the payload in shared memory, if it is not in the DATA. Specific to ddssec.
  std::optional<MemoryReference> memory = {};
  bool empty() const {
    return !key_hash && status == StatusInfo{} && coherence == CoherentSetInfo{} &&
           original.number.value == 0 && !source_time && filters.list.empty() && !memory;
  }
  bool operator==(const InlineQos&) const = default;
};

/// Errors: those of ParameterReader and SingleParameters, rtps_parameter_invalid (a value is too
/// short), rtps_number_invalid, rtps_parameter_not_understood.
Result<InlineQos> read_inline_qos(BytesView list, Endian endian);
/// Writes the list, including its sentinel.
void write(SpanWriter& out, const InlineQos& qos);

}  // namespace ddssec::rtps
