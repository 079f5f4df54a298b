#include "base/writer.hpp"

namespace ddssec {

void Writer::write_octet_sequence(BytesView octets) {
  write_aligned(static_cast<std::uint32_t>(octets.size()));
  write_bytes(octets);
}

void Writer::write_string(std::string_view text) {
  write_aligned(static_cast<std::uint32_t>(text.size() + 1));
  write_bytes(as_bytes(text));
  write<std::uint8_t>(0);
}

}  // namespace ddssec
