#include "wire/parameter_list.hpp"

namespace ddssec::rtps {

Result<ParameterHeader> read_parameter_header(Reader& reader) {
  ParameterHeader out;
  DDSSEC_ASSIGN_OR_RETURN(out.id, reader.read<std::uint16_t>());
  DDSSEC_ASSIGN_OR_RETURN(out.length, reader.read<std::uint16_t>());
  if (!out.is_sentinel() && out.length % 4 != 0) return fail(Code::rtps_parameter_invalid);
  return out;
}

Result<std::optional<Parameter>> ParameterReader::next() {
  while (true) {
    DDSSEC_ASSIGN_OR_RETURN(auto parameter, next_or_pad());
    if (!parameter || parameter->id != pid::kPad) return parameter;
  }
}

Result<std::optional<Parameter>> ParameterReader::next_or_pad() {
  if (is_done_) return std::nullopt;
  DDSSEC_ASSIGN_OR_RETURN(const auto header, read_parameter_header(reader_));
  is_done_ = header.is_sentinel();
  if (is_done_) return std::nullopt;
  DDSSEC_ASSIGN_OR_RETURN(const auto value, reader_.read_bytes(header.length));
  return Parameter{header.id, value, reader_.endian()};
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
