// Datagrams that a plugin sends itself, beside the host.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "base/bytes.hpp"
#include "base/ids.hpp"
#include "plugins/spi/udp_address.hpp"

namespace ddssec::cyclonedds {

/// Sends one datagram to each address from a socket of its own, without waiting or
/// reporting an error.
void send_datagram(BytesView datagram, std::span<const spi::UdpAddress> to) noexcept;

/// The same to the default multicast address of discovery (RTPS 9.6.2.4.1), IPv4, over each
/// interface on which a process listens to it.
void send_to_discovery(BytesView datagram, DomainId domain) noexcept;

/// The interfaces in a file with the form of /proc/net/igmp on which that group was joined, by
/// their indexes; at most 64. `group`: the IPv4 address in network order.
std::vector<int> interfaces_joined_to(std::string_view igmp,
                                      std::span<const std::uint8_t, 4> group);

}  // namespace ddssec::cyclonedds
