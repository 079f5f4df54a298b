// Writes HEADER_EXTENSION, which ddssec only reads.
#pragma once

#include "wire/header_extension.hpp"

namespace ddssec::rtps {

inline void write(SpanWriter& out, const HeaderExtension& extension) {
  std::uint8_t flags = extension.message_length ? 0x02 : 0;
  if (extension.send_time) flags |= 0x04;
  const SubmessageScope scope(out, SubmessageId::header_extension, flags);
  if (extension.message_length) out.write(*extension.message_length);
  if (extension.send_time) write_time(out, *extension.send_time);
}

}  // namespace ddssec::rtps
