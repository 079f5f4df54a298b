// Datagrams that a plugin sends itself, without the host.
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

/// Sends one datagram to each address, from a private socket, without waiting or reporting an
/// error. For a link-local IPv6 address it uses every interface that has a link-local address
/// itself, because the peer's address does not identify the link.
void send_datagram(BytesView datagram, std::span<const spi::UdpAddress> to) noexcept;

/// A multicast group that this machine has joined on one interface.
struct JoinedGroup {
  int interface = 0;  ///< index of the interface
  bool is_ipv6 = false;
  std::array<std::uint8_t, 16> address = {};  ///< as in spi::UdpAddress
  bool operator==(const JoinedGroup&) const = default;
};

/// Returns the groups in the contents of /proc/net/igmp and /proc/net/igmp6, at most 64. Groups
/// that every machine joins, or that belong to a local protocol (224.0.0.0/24, ff02::1 and the
/// like), are left out.
std::vector<JoinedGroup> joined_groups(std::string_view igmp, std::string_view igmp6);

/// Returns the ports of this process's UDP sockets that other processes may share, as is usual for
/// multicast; at most 16.
std::vector<std::uint16_t> shared_ports();

/// True if any UDP socket of this process is bound; empty if /proc does not list its sockets.
std::optional<bool> has_bound_udp();

/// Returns the interfaces with a link-local address in the contents of /proc/net/if_inet6; at most
/// 16.
std::vector<int> link_local_interfaces(std::string_view if_inet6);

/// Sends one datagram to every multicast address on which this process may receive discovery: the
/// host's configuration can name any group and port. The addresses are looked up at most once a
/// second.
void send_to_discovery(BytesView datagram) noexcept;

}  // namespace ddssec::cyclonedds
