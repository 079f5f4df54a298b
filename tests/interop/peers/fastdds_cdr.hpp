// A sample of Fast DDS and its octets: the frame around the fields of a type written by hand, since
// Debian has no Fast DDS code generator.
#ifndef DDSSEC_INTEROP_FASTDDS_CDR_HPP
#define DDSSEC_INTEROP_FASTDDS_CDR_HPP

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastdds/rtps/common/SerializedPayload.h>

namespace interop_fast {

using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;
using eprosima::fastrtps::rtps::SerializedPayload_t;

/// `fields(cdr)` behind an encapsulation header, in XCDR1; false: the payload is too small.
template <class F>
bool write_cdr(SerializedPayload_t& payload, F fields) {
  FastBuffer buffer(reinterpret_cast<char*>(payload.data), payload.max_size);
  Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
  payload.encapsulation = cdr.endianness() == Cdr::BIG_ENDIANNESS ? CDR_BE : CDR_LE;
  try {
    cdr.serialize_encapsulation();
    fields(cdr);
  } catch (const eprosima::fastcdr::exception::Exception&) {
    return false;
  }
  payload.length = static_cast<uint32_t>(cdr.getSerializedDataLength());
  return true;
}

/// `fields(cdr)` in the order of octets that the header names; false: there are too few.
template <class F>
bool read_cdr(SerializedPayload_t& payload, F fields) {
  FastBuffer buffer(reinterpret_cast<char*>(payload.data), payload.length);
  Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
  try {
    cdr.read_encapsulation();
    payload.encapsulation = cdr.endianness() == Cdr::BIG_ENDIANNESS ? CDR_BE : CDR_LE;
    fields(cdr);
  } catch (const eprosima::fastcdr::exception::Exception&) {
    return false;
  }
  return true;
}

}  // namespace interop_fast

#endif
