#include "wire/memory_reference.hpp"

#include "wire/parameter_list.hpp"

namespace ddssec::rtps {

Result<MemoryReference> read_memory_reference(BytesView value, Endian endian) {
  if (value.size() < kMemoryReferenceSize) return fail(Code::rtps_parameter_invalid);
  Reader reader(value, endian);
  MemoryReference out;
  DDSSEC_ASSIGN_OR_RETURN(out.segment, reader.read<std::uint64_t>());
  DDSSEC_ASSIGN_OR_RETURN(out.offset, reader.read<std::uint64_t>());
  DDSSEC_ASSIGN_OR_RETURN(out.generation, reader.read<std::uint64_t>());
  DDSSEC_ASSIGN_OR_RETURN(out.length, reader.read<std::uint32_t>());
  return out;
}

void write_memory_reference(SpanWriter& out, const MemoryReference& reference) {
  const ParameterScope scope(out, pid::kMemoryReference);
  out.write(reference.segment);
  out.write(reference.offset);
  out.write(reference.generation);
  out.write(reference.length);
}

}  // namespace ddssec::rtps
