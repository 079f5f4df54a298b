#include "wire/parameter_list.hpp"

namespace ddssec::rtps {

Result<std::optional<Parameter>> ParameterReader::next() {
  while (!is_done_) {
    DDSSEC_ASSIGN_OR_RETURN(const auto id, reader_.read<std::uint16_t>());
    DDSSEC_ASSIGN_OR_RETURN(const auto length, reader_.read<std::uint16_t>());
    if (id == pid::kSentinel) {
      is_done_ = true;
      break;
    }
    if (length % 4 != 0) return fail(Code::rtps_parameter_invalid);
    DDSSEC_ASSIGN_OR_RETURN(const auto value, reader_.read_bytes(length));
    if (id != pid::kPad) return Parameter{id, value, reader_.endian()};
  }
  return std::nullopt;
}

Result<BytesView> parameter_list_prefix(BytesView octets, Endian endian) {
  ParameterReader parameters(octets, endian);
  while (true) {
    DDSSEC_ASSIGN_OR_RETURN(const auto next, parameters.next());
    if (!next) break;
  }
  return octets.first(parameters.consumed());
}

}  // namespace ddssec::rtps
