#include "rtps/discovery/parameter_table.hpp"

namespace ddssec::rtps {

void write_pl_cdr_encapsulation(SpanWriter& out) {
  const bool little = out.endian() == Endian::little;
  const std::uint8_t octets[] = {0, static_cast<std::uint8_t>(little ? 3 : 2), 0, 0};
  out.write_bytes(octets);
}

Result<SerializedPayload> open_pl_cdr(BytesView payload) {
  DDSSEC_ASSIGN_OR_RETURN(auto opened, open_payload(payload));
  if (opened.encapsulation != Encapsulation::pl_cdr)
    return fail(Code::rtps_encapsulation_unsupported);
  return opened;
}

Result<std::string> read_bounded_string(Reader& reader, std::size_t max_length) {
  DDSSEC_ASSIGN_OR_RETURN(const auto text, reader.read_string());
  if (text.size() > max_length) return fail(Code::length_out_of_range);
  return std::string(text);
}

Result<Bytes> read_opaque(Reader& reader) {
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, reader.read_octet_sequence());
  if (octets.size() > kMaxOpaqueOctets) return fail(Code::length_out_of_range);
  return to_bytes(octets);
}

Status read_locator_into(Reader& reader, LocatorList& list) {
  DDSSEC_ASSIGN_OR_RETURN(const auto locator, read_locator(reader));
  if (list.size() >= kMaxLocators) return fail(Code::length_out_of_range);
  list.push_back(locator);
  return {};
}

void write_text(SpanWriter& out, std::string_view text) {
  out.align(4);
  out.write(static_cast<std::uint32_t>(text.size() + 1));
  out.write_bytes(as_bytes(text));
  out.write(std::uint8_t{0});
}

void write_opaque(SpanWriter& out, BytesView octets) {
  out.align(4);
  out.write(static_cast<std::uint32_t>(octets.size()));
  out.write_bytes(octets);
}

void write_locators(SpanWriter& out, ParameterId id, const LocatorList& list) {
  for (const auto& locator : list) {
    const ParameterScope scope(out, id);
    write_locator(out, locator);
  }
}

}  // namespace ddssec::rtps
