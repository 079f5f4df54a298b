#include "rtps/cdr/cdr_writer.hpp"

namespace ddssec::rtps::detail {

void begin_payload(Bytes& out, Encapsulation kind, Endian endian) {
  const auto id =
      static_cast<std::uint16_t>(static_cast<std::uint16_t>(kind) | (endian == Endian::little));
  out.assign({static_cast<std::uint8_t>(id >> 8), static_cast<std::uint8_t>(id), 0, 0});
}

void end_payload(Bytes& out) {
  const auto padding = -out.size() & 3u;
  out.resize(out.size() + padding);
  out[3] = static_cast<std::uint8_t>(padding);
}

}  // namespace ddssec::rtps::detail
