// Hides PID_TYPE_INFORMATION (DDS-XTypes 7.6.3.2.2) of peers from Cyclone DDS.
//
// Version 0.10.2 of the core crashes on unexpected type identifiers. It also follows types that
// depend on each other without a limit: in a circle, along every path through layers, and to any
// depth of a chain. It asks the peer for types that it does not know, and continues with those in
// the reply. Each of these messages is well-formed. Without type information, Cyclone DDS matches
// endpoints by the name of their type, as with vendors that announce none.
#pragma once

#include <cstdint>
#include <optional>

#include "base/bytes.hpp"

namespace ddssec::cryptography {

/// The position of the parameter id, if there is one.
using TypeInformationAt = std::optional<std::uint32_t>;

/// Replaces the parameter id by PID_PAD (RTPS 9.6.3.2.1), so that the receiver ignores the
/// parameter. The octets that follow stay in place.
inline void hide_type_information(MutableBytes octets, std::uint32_t at) {
  octets[at] = octets[at + 1] = 0;
}

}  // namespace ddssec::cryptography
