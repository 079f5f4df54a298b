// Datagrams that a plugin sends itself, beside the host.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "base/bytes.hpp"
#include "plugins/spi/udp_address.hpp"

namespace ddssec::cyclonedds {

/// Sends one datagram to each address from a socket of its own, without waiting or
/// reporting an error. To an IPv6 address that is link-local it goes over each interface that has
/// such an address itself, since the peer's address does not tell which link it is on.
void send_datagram(BytesView datagram, std::span<const spi::UdpAddress> to) noexcept;

/// A group that this machine has joined, on one interface.
struct JoinedGroup {
  int interface = 0;  ///< its index
  bool is_ipv6 = false;
  std::array<std::uint8_t, 16> address = {};  ///< as in spi::UdpAddress
  bool operator==(const JoinedGroup&) const = default;
};

/// The groups in files of the forms of /proc/net/igmp and /proc/net/igmp6, without those that every
/// machine joins or that belong to a local protocol (224.0.0.0/24, ff02::1 and the like); at most
/// 64.
std::vector<JoinedGroup> joined_groups(std::string_view igmp, std::string_view igmp6);

/// The ports of this process's UDP sockets that are shared between processes, as those are on which
/// multicast is heard; at most 16.
std::vector<std::uint16_t> shared_ports();

/// Whether any UDP socket of this process is bound; nothing if /proc does not tell its sockets.
std::optional<bool> has_bound_udp();

/// The interfaces with a link-local address, in a file of the form of /proc/net/if_inet6; at most
/// 16.
std::vector<int> link_local_interfaces(std::string_view if_inet6);

/// The same to every multicast address on which this process may listen to discovery: the host's
/// configuration can name any group and port. They are looked up at most once a second.
void send_to_discovery(BytesView datagram) noexcept;

}  // namespace ddssec::cyclonedds
