// Turns announcements into octets, for code that stores them or passes them on.
#pragma once

#include "rtps/discovery/endpoint_data.hpp"
#include "rtps/discovery/participant_data.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::rtps {

/// Returns what write_payload writes, however long it is.
template <class Data>
Bytes serialized(const Data& data) {
  for (std::size_t size = 4096;; size *= 2) {
    Bytes out(size);
    SpanWriter writer(out);
    write_payload(writer, data);
    if (writer.overflowed()) continue;
    out.resize(writer.size());
    return out;
  }
}

}  // namespace ddssec::rtps
