// PID_TYPE_INFORMATION (DDS-XTypes 7.6.3.2.2) of peers, hidden from Cyclone DDS.
//
// Version 0.10.2 of the core ends its process at type identifiers that it does not expect, and
// follows types that depend on one another without an end: in a circle, along every path through
// layers, as deep as a chain goes. It also asks the peer for types that it does not know, and goes
// on from what the reply says. Each of these messages is well-formed. Without type information it
// matches endpoints by the name of their type, as with vendors that announce none.
#pragma once

#include <cstdint>
#include <optional>

#include "base/bytes.hpp"

namespace ddssec::cryptography {

/// Where the parameter id stands, if there is one.
using TypeInformationAt = std::optional<std::uint32_t>;

/// Makes the two octets there PID_PAD (RTPS 9.6.3.2.1): the receiver ignores the parameter,
/// whatever it holds. The octets that follow stay in their places.
inline void hide_type_information(MutableBytes octets, std::uint32_t at) {
  octets[at] = octets[at + 1] = 0;
}

}  // namespace ddssec::cryptography
