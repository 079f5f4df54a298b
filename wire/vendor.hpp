// Vendor ids and protocol versions (RTPS 9.3.2.2, 9.3.2.3).
#pragma once

#include "base/ids.hpp"

namespace ddssec::rtps {

using VendorId = Id<struct VendorIdTag, 2>;
using ProtocolVersion = Id<struct ProtocolVersionTag, 2>;

/// The vendor id of ddssec, which the OMG has not assigned. Defined only here.
inline constexpr VendorId kVendorDdssec{{0x01, 0xd5}};
inline constexpr VendorId kVendorFastDds{{0x01, 0x0f}};
inline constexpr VendorId kVendorCyclone{{0x01, 0x10}};

/// The announced version. DDS-Security 1.2, clause 7.4.6.1, requires at least 2.3, which Cyclone
/// DDS and Fast DDS accept.
inline constexpr ProtocolVersion kProtocolVersion{{2, 3}};

}  // namespace ddssec::rtps
