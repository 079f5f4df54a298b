// The address at which a peer receives datagrams: the part of RTPS Locator_t (RTPS 9.3.2) that
// plugins need.
#pragma once

#include <array>
#include <cstdint>

namespace ddssec::spi {

/// A unicast address. `address` is in network order; for IPv4 only its last 4 octets count.
struct UdpAddress {
  bool is_ipv6 = false;
  std::uint16_t port = 0;
  std::array<std::uint8_t, 16> address{};

  bool operator==(const UdpAddress&) const = default;
};

}  // namespace ddssec::spi
