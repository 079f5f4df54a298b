#include "wire/parameter_list.hpp"

namespace ddssec::rtps {

Result<std::optional<Parameter>> ParameterReader::next() {
  while (!done_) {
    const auto id = DDSSEC_TRY(reader_.read<std::uint16_t>());
    const auto length = DDSSEC_TRY(reader_.read<std::uint16_t>());
    if (id == pid::kSentinel) {
      done_ = true;
      break;
    }
    if (length % 4 != 0) return fail(Code::rtps_parameter_invalid);
    const auto value = DDSSEC_TRY(reader_.read_bytes(length));
    if (id != pid::kPad) return Parameter{id, value, reader_.endian()};
  }
  return std::nullopt;
}

Result<BytesView> parameter_list_prefix(BytesView octets, Endian endian) {
  ParameterReader parameters(octets, endian);
  while (DDSSEC_TRY(parameters.next())) {
  }
  return octets.first(parameters.consumed());
}

}  // namespace ddssec::rtps
