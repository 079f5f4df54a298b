// What Fast DDS's CDR makes of values, with the encapsulation of XCDR1, little-endian.
#pragma once

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>

#include "base/bytes.hpp"

namespace ddssec::rtps {

/// `write(cdr)` puts the values.
template <class F>
Bytes fast_cdr(F&& write) {
  std::vector<char> room(65536);
  eprosima::fastcdr::FastBuffer buffer(room.data(), room.size());
  eprosima::fastcdr::Cdr cdr(buffer, eprosima::fastcdr::Cdr::LITTLE_ENDIANNESS,
                             eprosima::fastcdr::Cdr::DDS_CDR);
  cdr.serialize_encapsulation();
  write(cdr);
  Bytes out(room.begin(),
            room.begin() + static_cast<std::ptrdiff_t>(cdr.getSerializedDataLength()));
  // Our payloads are padded and say so in their options.
  const auto padding = -out.size() & 3u;
  out.resize(out.size() + padding);
  out[3] = static_cast<std::uint8_t>(padding);
  return out;
}

}  // namespace ddssec::rtps
