#include "wire/numbers.hpp"

#include <limits>

namespace ddssec::rtps {

Result<SequenceNumber> read_any_sequence_number(Reader& reader) {
  DDSSEC_ASSIGN_OR_RETURN(const std::int64_t high, reader.read<std::int32_t>());
  DDSSEC_ASSIGN_OR_RETURN(const auto low, reader.read<std::uint32_t>());
  return SequenceNumber{high * (std::int64_t{1} << 32) + low};
}

Result<SequenceNumber> read_sequence_number(Reader& reader) {
  DDSSEC_ASSIGN_OR_RETURN(const auto number, read_any_sequence_number(reader));
  if (!is_valid(number)) return fail(Code::rtps_number_invalid);
  return number;
}

Result<SequenceNumberSet> read_sequence_number_set(Reader& reader, std::int64_t min_base) {
  DDSSEC_ASSIGN_OR_RETURN(const auto base, read_any_sequence_number(reader));
  if (base.value < min_base || base > kMaxSequenceNumber) return fail(Code::rtps_number_invalid);
  SequenceNumberSet set(base);
  DDSSEC_RETURN_IF_ERROR(set.read_bits(reader));
  return set;
}

Result<FragmentNumberSet> read_fragment_number_set(Reader& reader) {
  DDSSEC_ASSIGN_OR_RETURN(const auto first, reader.read<std::uint32_t>());
  const FragmentNumber base{first};
  if (base.value < 1 || base.value > std::numeric_limits<std::uint32_t>::max() - kMaxBitsPerSet)
    return fail(Code::rtps_number_invalid);
  FragmentNumberSet set(base);
  DDSSEC_RETURN_IF_ERROR(set.read_bits(reader));
  return set;
}

}  // namespace ddssec::rtps
