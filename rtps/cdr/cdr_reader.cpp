#include "rtps/cdr/cdr_reader.hpp"

namespace ddssec::rtps {

void CdrReader::take_text(std::string& value, std::size_t bound) {
  const auto length = take_bits<std::uint32_t>();
  if (length > remaining()) refuse(Code::truncated);
  if (!status_) return;
  const auto octets = *reader_.read_bytes(length);
  // Some peers write "" with length 0. The NUL is checked and not assumed, because of
  // CVE-2023-23932.
  const auto text = as_text(octets.empty() ? octets : octets.first(length - 1));
  if (!octets.empty() && octets.back() != 0) return refuse(Code::malformed);
  if (text.find('\0') != text.npos) return refuse(Code::malformed);
  if (text.size() > bound) return refuse(Code::length_out_of_range);
  value = text;
}

CdrReader::DelimitedScope::DelimitedScope(CdrReader& reader, bool wanted)
    : reader_(reader),
      outer_end_(reader.end_),
      is_active_(wanted && reader.version_ == XcdrVersion::xcdr2) {
  if (!is_active_) return;
  const auto size = reader_.take_bits<std::uint32_t>();
  if (size > reader_.remaining()) reader_.refuse(Code::truncated);
  if (reader_.status_) reader_.end_ = reader_.reader_.position() + size;
}

CdrReader::DelimitedScope::~DelimitedScope() {
  if (!is_active_ || !reader_.status_) return;
  static_cast<void>(reader_.reader_.skip(reader_.remaining()));
  reader_.end_ = outer_end_;
}

namespace detail {

Result<CdrReader> open_reader(BytesView payload, Extensibility extensibility) {
  DDSSEC_ASSIGN_OR_RETURN(const auto opened, open_payload(payload));
  const auto kind = opened.encapsulation;
  const bool appendable = extensibility == Extensibility::appendable;
  const bool fits = kind == Encapsulation::cdr ||
                    kind == (appendable ? Encapsulation::delimited_cdr2 : Encapsulation::cdr2);
  if (!fits) return fail(Code::rtps_encapsulation_unsupported);
  return CdrReader(opened.body, version_of(kind), opened.endian);
}

Result<CdrReader> open_key_reader(BytesView payload, Extensibility extensibility) {
  DDSSEC_ASSIGN_OR_RETURN(const auto opened, open_payload(payload));
  const auto kind = opened.encapsulation;
  const bool appendable = extensibility == Extensibility::appendable;
  const bool fits = kind == Encapsulation::cdr || kind == Encapsulation::cdr2 ||
                    (appendable && kind == Encapsulation::delimited_cdr2);
  if (!fits) return fail(Code::rtps_encapsulation_unsupported);
  return CdrReader(opened.body, version_of(kind), opened.endian);
}

}  // namespace detail
}  // namespace ddssec::rtps
