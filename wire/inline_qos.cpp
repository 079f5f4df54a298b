#include "wire/inline_qos.hpp"

#include <algorithm>
#include <array>

#include "wire/parameter_list.hpp"
#include "wire/submessage.hpp"

namespace ddssec::rtps {
namespace {

constexpr std::uint8_t kDisposed = 0x01;
constexpr std::uint8_t kUnregistered = 0x02;
constexpr std::uint8_t kFiltered = 0x04;

// True if an unknown id must stop the reader. Standard ids below 0x4000 may be ignored.
bool must_be_understood(ParameterId id) {
  return (id & pid::kMustUnderstand) != 0 && (id & pid::kVendorSpecific) == 0;
}

Result<SequenceNumber> read_number(BytesView value, Endian endian) {
  Reader reader(value, endian);
  DDSSEC_ASSIGN_OR_RETURN(const auto number, read_any_sequence_number(reader));
  constexpr SequenceNumber kUnknown{-(std::int64_t{1} << 32)};
  if (number == kUnknown) return SequenceNumber{};
  if (!is_valid(number)) return fail(Code::rtps_number_invalid);
  return number;
}

// Reads a GUID and a sequence number. The list that may follow is not needed.
Result<OriginalWriterInfo> read_original(BytesView value, Endian endian) {
  if (value.size() < 24) return fail(Code::rtps_parameter_invalid);
  Reader reader(value, endian);
  DDSSEC_ASSIGN_OR_RETURN(const auto guid, read_guid(reader));
  OriginalWriterInfo out{guid, {}};
  DDSSEC_ASSIGN_OR_RETURN(out.number, read_sequence_number(reader));
  return out;
}

// Returns the member of Coherence that a parameter sets, or nullptr.
constexpr SequenceNumber CoherentSetInfo::*number_of(ParameterId id) {
  switch (id) {
    case pid::kCoherentSet:
      return &CoherentSetInfo::set;
    case pid::kGroupCoherentSet:
      return &CoherentSetInfo::group_set;
    case pid::kGroupSeqNum:
      return &CoherentSetInfo::group;
    default:
      return nullptr;
  }
}

// The parameters that are read. Each has one value.
constexpr std::array kKnown = {
    pid::kKeyHash,        pid::kStatusInfo,      pid::kCoherentSet,        pid::kGroupCoherentSet,
    pid::kGroupSeqNum,    pid::kWriterGroupInfo, pid::kOriginalWriterInfo, pid::kSourceTime,
    pid::kMemoryReference};

// True if the length shows that another vendor uses one of ddssec's own ids for something else.
bool is_of_another_vendor(const Parameter& parameter) {
  const auto size = parameter.value.size();
  return (parameter.id == pid::kSourceTime && size < 8) ||
         (parameter.id == pid::kMemoryReference && size != kMemoryReferenceSize);
}

// Reads a parameter whose id is in kKnown.
Status take(const Parameter& parameter, InlineQos& qos) {
  const auto& [id, value, endian] = parameter;
  if (id == pid::kKeyHash) {
    if (value.size() < 16) return fail(Code::rtps_parameter_invalid);
    std::copy_n(value.begin(), 16, qos.key_hash.emplace().begin());
  } else if (id == pid::kStatusInfo) {
    if (value.size() < 4) return fail(Code::rtps_parameter_invalid);
    qos.status = {(value[3] & kDisposed) != 0, (value[3] & kUnregistered) != 0,
                  (value[3] & kFiltered) != 0};
  } else if (const auto number = number_of(id)) {
    if (value.size() < 8) return fail(Code::rtps_parameter_invalid);
    DDSSEC_ASSIGN_OR_RETURN(qos.coherence.*number, read_number(value, endian));
  } else if (id == pid::kWriterGroupInfo) {
    if (value.size() < 4) return fail(Code::rtps_parameter_invalid);
    std::copy_n(value.begin(), 4, qos.coherence.writers.begin());
  } else if (id == pid::kOriginalWriterInfo) {
    DDSSEC_ASSIGN_OR_RETURN(qos.original, read_original(value, endian));
  } else if (id == pid::kSourceTime) {
    Reader reader(value, endian);
    DDSSEC_ASSIGN_OR_RETURN(qos.source_time, read_time(reader));
  } else {
    DDSSEC_ASSIGN_OR_RETURN(qos.memory, read_memory_reference(value, endian));
  }
  return {};
}

void write_number(SpanWriter& out, ParameterId id, SequenceNumber number) {
  if (number.value == 0) return;
  const ParameterScope scope(out, id);
  write_sequence_number(out, number);
}

}  // namespace

Result<InlineQos> read_inline_qos(BytesView list, Endian endian) {
  InlineQos qos;
  ParameterReader parameters(list, endian);
  SingleParameters single;
  while (true) {
    DDSSEC_ASSIGN_OR_RETURN(const auto parameter, parameters.next());
    if (!parameter) break;

    const auto place = std::ranges::find(kKnown, parameter->id);
    if (place != kKnown.end() && !is_of_another_vendor(*parameter)) {
      DDSSEC_RETURN_IF_ERROR(single.note(static_cast<std::size_t>(place - kKnown.begin())));
      DDSSEC_RETURN_IF_ERROR(take(*parameter, qos));
    } else if (must_be_understood(parameter->id)) {
      return fail(Code::rtps_parameter_not_understood);
    }
  }
  return qos;
}

void write(SpanWriter& out, const InlineQos& qos) {
  if (qos.key_hash) {
    const ParameterScope scope(out, pid::kKeyHash);
    out.write_bytes(*qos.key_hash);
  }
  if (qos.status != StatusInfo{}) {
    const ParameterScope scope(out, pid::kStatusInfo);
    const auto flags = static_cast<std::uint8_t>((qos.status.disposed ? kDisposed : 0) |
                                                 (qos.status.unregistered ? kUnregistered : 0) |
                                                 (qos.status.filtered ? kFiltered : 0));
    const std::array<std::uint8_t, 4> octets{0, 0, 0, flags};
    out.write_bytes(octets);
  }
  if (qos.coherence != CoherentSetInfo{}) {
    write_number(out, pid::kCoherentSet, qos.coherence.set);
    write_number(out, pid::kGroupCoherentSet, qos.coherence.group_set);
    write_number(out, pid::kGroupSeqNum, qos.coherence.group);
    if (qos.coherence.writers != GroupDigest{}) {
      const ParameterScope scope(out, pid::kWriterGroupInfo);
      out.write_bytes(qos.coherence.writers);
    }
  }
  if (qos.original.number.value > 0) {
    const ParameterScope scope(out, pid::kOriginalWriterInfo);
    out.write_bytes(qos.original.writer.octets());
    write_sequence_number(out, qos.original.number);
  }
  if (qos.source_time) {
    const ParameterScope scope(out, pid::kSourceTime);
    write_time(out, *qos.source_time);
  }
  write_content_filter_info(out, qos.filters);
  if (qos.memory) write_memory_reference(out, *qos.memory);
  write_sentinel(out);
}

}  // namespace ddssec::rtps
