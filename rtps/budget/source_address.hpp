// The source of a datagram, for limits that are shared among sources.
#pragma once

#include <algorithm>

#include "wire/locator.hpp"

namespace ddssec::rtps {

/// An IPv4 address, or the first 64 bits of an IPv6 address, because one host has all addresses
/// below these. It has no port, because one host has all ports. All datagrams from unknown sources
/// have the same source address.
class SourceAddress {
 public:
  SourceAddress() = default;
  explicit SourceAddress(const Locator& source) : kind_(source.kind), octets_(source.address) {
    if (kind_ == LocatorKind::udp_v6) std::fill(octets_.begin() + 8, octets_.end(), 0);
  }
  auto operator<=>(const SourceAddress&) const = default;
  /// Returns the octets of the address; an IPv4 address follows 12 zeros.
  BytesView octets() const { return octets_; }

 private:
  LocatorKind kind_ = LocatorKind::invalid;
  std::array<std::uint8_t, 16> octets_{};
};

}  // namespace ddssec::rtps
