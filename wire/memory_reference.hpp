// The place of a DATA's payload in shared memory. Specific to ddssec.
#pragma once

#include <cstdint>

#include "base/reader.hpp"

namespace ddssec::rtps {

class SpanWriter;

/// Names a payload in a segment of its writer (rtps/memory). A DATA carries this reference instead
/// of the payload, so the reference has the same protection as the rest of the DATA.
struct MemoryReference {
  std::uint64_t segment = 0;     ///< a random number that identifies the segment
  std::uint64_t offset = 0;      ///< position of the slot, in octets
  std::uint64_t generation = 0;  ///< the generation that the slot must have; even
  std::uint32_t length = 0;      ///< size of the payload, in octets

  bool operator==(const MemoryReference&) const = default;
};

inline constexpr std::size_t kMemoryReferenceSize = 28;  ///< size of the value, in octets

/// Reads the value of the parameter. A peer may have put any numbers into it, so rtps/memory checks
/// them. Error: rtps_parameter_invalid (too short).
Result<MemoryReference> read_memory_reference(BytesView value, Endian endian);
/// Writes the parameter, with its id and length.
void write_memory_reference(SpanWriter& out, const MemoryReference& reference);

}  // namespace ddssec::rtps
