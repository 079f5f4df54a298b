// Where the payload of a DATA is in shared memory. Specific to ddssec.
#pragma once

#include "wire/parameter_list.hpp"

namespace ddssec::rtps {

/// Names a payload in a segment of its writer (rtps/memory). A DATA carries it instead of the
/// payload, so that it is protected as all of the DATA is.
struct MemoryReference {
  std::uint64_t segment = 0;     ///< which segment; a random number
  std::uint64_t offset = 0;      ///< of the slot, in octets
  std::uint64_t generation = 0;  ///< what the slot must have; even
  std::uint32_t length = 0;      ///< of the payload, in octets

  bool operator==(const MemoryReference&) const = default;
};

inline constexpr std::size_t kMemoryReferenceSize = 28;  ///< of the value, in octets

/// Reads the value of the parameter. Its content may lead anywhere: rtps/memory checks it. Error:
/// rtps_parameter_invalid (too short).
Result<MemoryReference> read_memory_reference(BytesView value, Endian endian);
/// Writes the parameter.
void write_memory_reference(SpanWriter& out, const MemoryReference& reference);

}  // namespace ddssec::rtps
