// The network interfaces of this machine, and the selection of those that a participant uses.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "wire/locator.hpp"

namespace ddssec::rtps {

/// An address of this machine, with the network that it reaches.
struct NetworkInterface {
  std::string name;             ///< empty for an address that no interface lists, such as 127.0.0.2
  Locator address;              ///< without a port
  std::size_t prefix_bits = 0;  ///< number of bits of the network prefix
  bool multicast = false;

  bool operator==(const NetworkInterface&) const = default;
  /// True if `locator` is an address in the same network.
  bool reaches(const Locator& locator) const;
};

/// The largest number of interfaces of a participant, because one socket cannot join more groups
/// (igmp_max_memberships).
inline constexpr std::size_t kMaxInterfaces = 16;

/// Returns every interface that is up, with its first IPv4 address or, if it has none, its first
/// IPv6 address.
std::vector<NetworkInterface> interfaces_of_this_machine();

/// Returns all addresses of this machine, without ports.
LocatorList addresses_of_this_machine();

/// Returns the interfaces in `wanted`, given by name or address. If `wanted` is empty, returns the
/// IPv4 interfaces that are up, support multicast and are not the loopback, as other vendors choose
/// theirs. If there are none, returns the loopback. Errors: rtps_address_not_here, invalid_property
/// (more than kMaxInterfaces, not an address, or IPv4 and IPv6 together).
Result<std::vector<NetworkInterface>> choose_interfaces(std::span<const std::string> wanted);

/// Returns a text such as "eth0 (192.0.2.2) and wlan0 (192.0.2.130)".
std::string to_string(std::span<const NetworkInterface> interfaces);

/// Keeps the addresses of a participant by which it can be reached best from `own`.
/// - If all are addresses of this machine, one is enough.
/// - Otherwise, addresses of this machine are removed: they belong to another network with the same
///   numbers, as Docker creates them everywhere.
/// - If some are in a network of `own`, the others are removed.
void keep_nearest(std::vector<Locator>& locators, std::span<const NetworkInterface> own);

}  // namespace ddssec::rtps
