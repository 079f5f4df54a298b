// Where a datagram came from, as far as room is shared by it.
#pragma once

#include <algorithm>

#include "wire/locator.hpp"

namespace ddssec::rtps {

/// An IPv4 address, or the first 64 bits of an IPv6 address, as one host has all addresses below
/// these. Without a port, as one host has all of them. All datagrams of unknown sources have the
/// same one.
class SourceAddress {
 public:
  SourceAddress() = default;
  explicit SourceAddress(const Locator& source) : kind_(source.kind), octets_(source.address) {
    if (kind_ == LocatorKind::udp_v6) std::fill(octets_.begin() + 8, octets_.end(), 0);
  }
  auto operator<=>(const SourceAddress&) const = default;
  /// Of the address; an IPv4 address follows 12 zeros.
  BytesView octets() const { return octets_; }

 private:
  LocatorKind kind_ = LocatorKind::invalid;
  std::array<std::uint8_t, 16> octets_{};
};

}  // namespace ddssec::rtps
