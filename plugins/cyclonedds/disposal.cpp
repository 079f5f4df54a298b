#include "plugins/cyclonedds/disposal.hpp"

#include <array>

#include "wire/data.hpp"

namespace ddssec::cyclonedds {
namespace {

// Returns a payload that contains only the key.
std::array<std::uint8_t, 28> payload_of(const Disposal& disposal) {
  constexpr std::array<std::uint8_t, 4> kPlCdrLittleEndian{0, 3, 0, 0};
  std::array<std::uint8_t, 28> octets{};
  rtps::SpanWriter out(octets);
  out.write_bytes(kPlCdrLittleEndian);
  {
    const rtps::ParameterScope guid(out, disposal.key);
    out.write_bytes(disposal.gone.octets());
  }
  rtps::write_sentinel(out);
  return octets;
}

}  // namespace

void write(rtps::SpanWriter& out, const Disposal& disposal) {
  const auto payload = payload_of(disposal);
  rtps::write(out, rtps::Data{.reader = disposal.reader,
                              .writer = disposal.writer,
                              .sequence_number = disposal.number,
                              .inline_qos = {.key_hash = disposal.gone.octets(),
                                             .status = {.disposed = true, .unregistered = true}},
                              .kind = rtps::PayloadKind::key,
                              .payload = payload});
}

}  // namespace ddssec::cyclonedds
