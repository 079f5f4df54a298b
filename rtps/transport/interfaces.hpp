// The network interfaces of this machine, and which of them a participant uses.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "wire/locator.hpp"

namespace ddssec::rtps {

struct NetworkInterface {
  std::string name;             ///< empty: an address that no interface lists, as 127.0.0.2
  Locator address;              ///< without a port
  std::size_t prefix_bits = 0;  ///< how many bits of the address name its network
  bool multicast = false;

  /// Whether `locator` is an address of the same network.
  bool reaches(const Locator& locator) const;
};

/// What a participant uses at most: more groups cannot be joined by one socket
/// (igmp_max_memberships).
inline constexpr std::size_t kMaxInterfaces = 16;

/// Every interface that is up, with its first IPv4 address, or without one its first IPv6 address.
std::vector<NetworkInterface> interfaces_of_this_machine();

/// The interfaces that `wanted` names, each by its name or an address. If it names none: the IPv4
/// interfaces that are up, do multicast and are not the loopback, as other vendors choose theirs;
/// without any, the loopback. Errors: rtps_address_not_here, invalid_property (more than
/// kMaxInterfaces, no address, or IPv4 and IPv6 at once).
Result<std::vector<NetworkInterface>> choose_interfaces(std::span<const std::string> wanted);

/// "eth0 (192.0.2.2) and wlan0 (192.0.2.130)".
std::string to_string(std::span<const NetworkInterface> interfaces);

/// Of the addresses of one participant, those that lead to it from `own`. One is enough if all are
/// addresses of this machine; an address of this machine beside others is another network of the
/// same numbers (as Docker makes them everywhere); those in a network of `own` make the others
/// superfluous.
void keep_nearest(std::vector<Locator>& locators, std::span<const NetworkInterface> own);

}  // namespace ddssec::rtps
