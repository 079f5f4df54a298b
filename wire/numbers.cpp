#include "wire/numbers.hpp"

#include <limits>

namespace ddssec::rtps {

Result<SequenceNumber> read_any_sequence_number(Reader& reader) {
  const std::int64_t high = DDSSEC_TRY(reader.read<std::int32_t>());
  return SequenceNumber{high * (std::int64_t{1} << 32) + DDSSEC_TRY(reader.read<std::uint32_t>())};
}

Result<SequenceNumber> read_sequence_number(Reader& reader) {
  const auto number = DDSSEC_TRY(read_any_sequence_number(reader));
  if (!is_valid(number)) return fail(Code::rtps_number_invalid);
  return number;
}

Result<SequenceNumberSet> read_sequence_number_set(Reader& reader, std::int64_t least_base) {
  const auto base = DDSSEC_TRY(read_any_sequence_number(reader));
  if (base.value < least_base || base > kGreatestSequenceNumber)
    return fail(Code::rtps_number_invalid);
  SequenceNumberSet set(base);
  DDSSEC_TRY(set.read_bits(reader));
  return set;
}

Result<FragmentNumberSet> read_fragment_number_set(Reader& reader) {
  const FragmentNumber base{DDSSEC_TRY(reader.read<std::uint32_t>())};
  if (base.value < 1 || base.value > std::numeric_limits<std::uint32_t>::max() - kMostBitsPerSet)
    return fail(Code::rtps_number_invalid);
  FragmentNumberSet set(base);
  DDSSEC_TRY(set.read_bits(reader));
  return set;
}

}  // namespace ddssec::rtps
