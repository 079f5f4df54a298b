#include "rtps/cdr/encapsulation.hpp"

namespace ddssec::rtps {
namespace {

bool is_known(std::uint16_t kind) {
  switch (static_cast<Encapsulation>(kind)) {
    case Encapsulation::cdr:
    case Encapsulation::pl_cdr:
    case Encapsulation::cdr2:
    case Encapsulation::delimited_cdr2:
    case Encapsulation::pl_cdr2:
      return true;
  }
  return false;
}

}  // namespace

Result<SerializedPayload> open_payload(BytesView payload) {
  Reader reader(payload);
  DDSSEC_ASSIGN_OR_RETURN(const auto id, reader.read<std::uint16_t>());
  DDSSEC_ASSIGN_OR_RETURN(const auto options, reader.read<std::uint16_t>());
  const auto kind = static_cast<std::uint16_t>(id & ~1u);
  if (!is_known(kind)) return fail(Code::rtps_encapsulation_unsupported);
  // The two lowest option bits count the octets of padding at the end (XTypes 7.6.3.1.2).
  const std::size_t padding = options & 3u;
  if (padding > reader.remaining()) return fail(Code::truncated);
  return SerializedPayload{static_cast<Encapsulation>(kind),
                           (id & 1u) != 0 ? Endian::little : Endian::big,
                           reader.rest().first(reader.remaining() - padding)};
}

}  // namespace ddssec::rtps
