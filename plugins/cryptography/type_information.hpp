// Hides PID_TYPE_INFORMATION (DDS-XTypes 7.6.3.2.2) of peers from Cyclone DDS.
//
// Version 0.10.2 of the core crashes on unexpected type identifiers. It also follows types that
// depend on each other without a limit: in a circle, along every path through layers, and to any
// depth of a chain. It asks the peer for types that it does not know, and continues with those in
// the reply. Each of these messages is well-formed. Without type information, Cyclone DDS matches
// endpoints by the name of their type, as with vendors that announce none.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "base/bytes.hpp"

namespace ddssec::cryptography {

/// The place of the parameter id, and the octets that hide it.
struct TypeInformationPlace {
  std::uint32_t at;
  std::uint8_t octets = 2;  ///< 1 if the first octet of the id came in an earlier fragment
  std::uint8_t value = 0;   ///< value of each octet
};
/// The place, or nothing if there is no type information.
using TypeInformationAt = std::optional<TypeInformationPlace>;

/// Replaces the parameter id by one that the receiver ignores: PID_PAD (RTPS 9.6.3.2.1), or one of
/// a vendor. The octets that follow stay in place.
inline void hide_type_information(MutableBytes octets, const TypeInformationPlace& place) {
  std::ranges::fill(octets.subspan(place.at, place.octets), place.value);
}

}  // namespace ddssec::cryptography
