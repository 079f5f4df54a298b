// Values serialized by Fast DDS's CDR, with the encapsulation of XCDR1, little-endian.
#pragma once

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>

#include "base/bytes.hpp"

namespace ddssec::rtps {

#if DDSSEC_FASTCDR >= 2
constexpr auto kFastXcdr1 = eprosima::fastcdr::CdrVersion::XCDRv1;
inline std::size_t size_of(const eprosima::fastcdr::Cdr& cdr) {
  return cdr.get_serialized_data_length();
}
#else
constexpr auto kFastXcdr1 = eprosima::fastcdr::Cdr::DDS_CDR;
inline std::size_t size_of(const eprosima::fastcdr::Cdr& cdr) {
  return cdr.getSerializedDataLength();
}
#endif

/// Returns the values that `write(cdr)` puts.
template <class F>
Bytes fast_cdr(F&& write) {
  std::vector<char> room(65536);
  eprosima::fastcdr::FastBuffer buffer(room.data(), room.size());
  eprosima::fastcdr::Cdr cdr(buffer, eprosima::fastcdr::Cdr::LITTLE_ENDIANNESS, kFastXcdr1);
  cdr.serialize_encapsulation();
  write(cdr);
  Bytes out(room.begin(), room.begin() + static_cast<std::ptrdiff_t>(size_of(cdr)));
  // Our payloads are padded, and their options say so.
  const auto padding = -out.size() & 3u;
  out.resize(out.size() + padding);
  out[3] = static_cast<std::uint8_t>(padding);
  return out;
}

}  // namespace ddssec::rtps
