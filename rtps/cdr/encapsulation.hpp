// The four octets at the beginning of every serialized payload (RTPS 10.2, XTypes 7.6.3.1.2).
#pragma once

#include <cstdint>

#include "base/reader.hpp"

namespace ddssec::rtps {

/// RepresentationIdentifier without its lowest bit, which means little-endian.
enum class Encapsulation : std::uint16_t {
  cdr = 0x0000,             ///< XCDR1, final and appendable types
  pl_cdr = 0x0002,          ///< XCDR1 parameter list: discovery, mutable types
  cdr2 = 0x0006,            ///< XCDR2, final types
  delimited_cdr2 = 0x0008,  ///< XCDR2, appendable types
  pl_cdr2 = 0x000a,         ///< XCDR2, mutable types
};

inline constexpr std::size_t kEncapsulationSize = 4;

/// The two encodings, whose alignment differs.
enum class XcdrVersion : std::uint8_t { xcdr1, xcdr2 };

constexpr XcdrVersion version_of(Encapsulation kind) {
  return kind == Encapsulation::cdr || kind == Encapsulation::pl_cdr ? XcdrVersion::xcdr1
                                                                     : XcdrVersion::xcdr2;
}

/// A parsed payload. Borrows its octets.
struct SerializedPayload {
  Encapsulation encapsulation = Encapsulation::cdr;
  Endian endian = Endian::little;
  /// The body without the padding at its end; alignment counts from its first octet.
  BytesView body = {};
};

/// Parses the encapsulation. Errors: truncated, rtps_encapsulation_unsupported (an unknown id;
/// Cyclone DDS #1751).
Result<SerializedPayload> open_payload(BytesView payload);

}  // namespace ddssec::rtps
