#include "plugins/cyclonedds/datagrams.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <netinet/in.h>
#include <optional>
#include <sstream>
#include <sys/socket.h>
#include <unistd.h>

namespace ddssec::cyclonedds {
namespace {

constexpr std::size_t kMaxGroups = 64, kMaxPorts = 16, kMaxInterfaces = 16;

// Returns the address for the kernel, with its length. `scope` is the interface of a link-local
// address.
std::pair<sockaddr_storage, socklen_t> kernel_address(const spi::UdpAddress& address, int scope) {
  sockaddr_storage out{};
  if (address.is_ipv6) {
    sockaddr_in6 six{};
    six.sin6_family = AF_INET6;
    six.sin6_port = htons(address.port);
    six.sin6_scope_id = static_cast<std::uint32_t>(scope);
    std::memcpy(&six.sin6_addr, address.address.data(), 16);
    std::memcpy(&out, &six, sizeof six);
    return {out, sizeof six};
  }
  sockaddr_in four{};
  four.sin_family = AF_INET;
  four.sin_port = htons(address.port);
  std::memcpy(&four.sin_addr, address.address.data() + 12, 4);
  std::memcpy(&out, &four, sizeof four);
  return {out, sizeof four};
}

// True for fe80::/10.
bool is_link_local(const spi::UdpAddress& address) {
  return address.is_ipv6 && address.address[0] == 0xfe && (address.address[1] & 0xc0) == 0x80;
}

// Makes multicast from this socket leave by that interface.
bool goes_over(int socket, bool is_ipv6, int interface) {
  if (is_ipv6)
    return ::setsockopt(socket, IPPROTO_IPV6, IPV6_MULTICAST_IF, &interface, sizeof interface) == 0;
  ip_mreqn over{};
  over.imr_ifindex = interface;
  return ::setsockopt(socket, IPPROTO_IP, IP_MULTICAST_IF, &over, sizeof over) == 0;
}

// Sends one datagram. `interface` is an index, for multicast and link-local addresses; with 0 the
// system chooses.
void send_one(BytesView datagram, const spi::UdpAddress& to, int interface) noexcept {
  const int socket =
      ::socket(to.is_ipv6 ? AF_INET6 : AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (socket < 0) return;
  const auto [where, length] = kernel_address(to, is_link_local(to) ? interface : 0);
  if (interface == 0 || is_link_local(to) || goes_over(socket, to.is_ipv6, interface))
    (void)::sendto(socket, datagram.data(), datagram.size(), MSG_NOSIGNAL,
                   reinterpret_cast<const sockaddr*>(&where), length);
  ::close(socket);
}

std::string contents(const char* file) {
  std::ostringstream out;
  out << std::ifstream(file).rdbuf();
  return std::move(out).str();
}

template <class Number>
std::optional<Number> number_in(std::string_view text, int base) {
  Number out = 0;
  const auto* const end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, out, base);
  if (error != std::errc() || stopped != end) return std::nullopt;
  return out;
}

// The file has a line for an interface, then one for each of its groups, which begins with a
// blank.
void add_ipv4(std::vector<JoinedGroup>& out, std::string_view igmp) {
  std::istringstream lines{std::string(igmp)};
  int interface = 0;
  for (std::string line; std::getline(lines, line) && out.size() < kMaxGroups;) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (line.empty() || (line.front() != '\t' && line.front() != ' ')) {
      interface = number_in<int>(word, 10).value_or(0);
      continue;
    }
    const auto number = number_in<std::uint32_t>(word, 16);
    if (!number || interface <= 0) continue;
    JoinedGroup group{.interface = interface};
    // The kernel prints the four octets as one number in host byte order.
    std::memcpy(group.address.data() + 12, &*number, 4);
    const bool is_local =
        group.address[12] == 224 && group.address[13] == 0 && group.address[14] == 0;
    if (!is_local) out.push_back(group);
  }
}

// The file has one line for each group: the interface's index and name, and the address in 32
// digits.
void add_ipv6(std::vector<JoinedGroup>& out, std::string_view igmp6) {
  std::istringstream lines{std::string(igmp6)};
  for (std::string line; std::getline(lines, line) && out.size() < kMaxGroups;) {
    std::istringstream words(line);
    std::string index, name, digits;
    words >> index >> name >> digits;
    const auto interface = number_in<int>(index, 10);
    if (!interface || *interface <= 0 || digits.size() != 32) continue;
    JoinedGroup group{.interface = *interface, .is_ipv6 = true};
    bool is_address = true;
    for (std::size_t i = 0; i < 16; ++i) {
      const auto octet = number_in<std::uint8_t>(std::string_view(digits).substr(2 * i, 2), 16);
      is_address = is_address && octet;
      group.address.at(i) = octet.value_or(0);
    }
    // Local groups such as ff02::1 and ff02::1:ff00:0 have only zeros before the last five octets.
    const bool is_local = std::all_of(group.address.begin() + 2, group.address.begin() + 11,
                                      [](auto octet) { return octet == 0; }) &&
                          group.address[11] <= 1;
    if (is_address && !is_local) out.push_back(group);
  }
}

// Returns the port of a UDP socket; empty for other descriptors.
std::optional<std::uint16_t> bound_port(int socket) {
  int type = 0;
  socklen_t length = sizeof type;
  if (::getsockopt(socket, SOL_SOCKET, SO_TYPE, &type, &length) != 0 || type != SOCK_DGRAM)
    return std::nullopt;
  sockaddr_storage own{};
  socklen_t size = sizeof own;
  if (::getsockname(socket, reinterpret_cast<sockaddr*>(&own), &size) != 0) return std::nullopt;
  std::uint16_t port = 0;
  if (own.ss_family == AF_INET)
    port = ntohs(reinterpret_cast<const sockaddr_in&>(own).sin_port);
  else if (own.ss_family == AF_INET6)
    port = ntohs(reinterpret_cast<const sockaddr_in6&>(own).sin6_port);
  return port == 0 ? std::nullopt : std::optional(port);
}

// Returns the port of a UDP socket that other processes may bind too.
std::optional<std::uint16_t> shared_port(int socket) {
  int reuses_address = 0, reuses_port = 0;
  socklen_t length = sizeof reuses_port;
  (void)::getsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &reuses_address, &length);
  (void)::getsockopt(socket, SOL_SOCKET, SO_REUSEPORT, &reuses_port, &length);
  return reuses_address == 0 && reuses_port == 0 ? std::nullopt : bound_port(socket);
}

// Calls `f(descriptor)` for each descriptor of this process until it returns false. Returns false
// if the descriptors cannot be listed.
template <class F>
bool each_descriptor(F&& f) {
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", error))
    if (!f(std::atoi(entry.path().filename().c_str()))) return true;
  return !error;
}

// The addresses on which discovery may be received. They are cached, because finding them takes
// some system calls for each descriptor and may be needed for 32 peers in a row.
struct DiscoveryPlaces {
  std::vector<JoinedGroup> groups;
  std::vector<std::uint16_t> ports;
};

DiscoveryPlaces discovery_places() {
  using Clock = std::chrono::steady_clock;
  static std::mutex mutex;
  static auto& known = *new DiscoveryPlaces;  // never destroyed, because a timer may send at exit
  static std::optional<Clock::time_point> since;
  const std::lock_guard lock(mutex);
  if (!since || Clock::now() - *since >= std::chrono::seconds(1)) {
    known = {joined_groups(contents("/proc/self/net/igmp"), contents("/proc/self/net/igmp6")),
             shared_ports()};
    since = Clock::now();
  }
  return known;
}

void send_over_each_link(BytesView datagram, const spi::UdpAddress& to) noexcept {
  try {
    const auto interfaces = link_local_interfaces(contents("/proc/self/net/if_inet6"));
    if (interfaces.empty()) send_one(datagram, to, 0);
    for (const auto interface : interfaces) send_one(datagram, to, interface);
  } catch (...) {
    // As declared, nothing is sent if memory is short.
  }
}

}  // namespace

void send_datagram(BytesView datagram, std::span<const spi::UdpAddress> to) noexcept {
  for (const auto& address : to) {
    if (is_link_local(address))
      send_over_each_link(datagram, address);
    else
      send_one(datagram, address, 0);
  }
}

std::vector<JoinedGroup> joined_groups(std::string_view igmp, std::string_view igmp6) {
  std::vector<JoinedGroup> out;
  add_ipv4(out, igmp);
  add_ipv6(out, igmp6);
  return out;
}

std::vector<std::uint16_t> shared_ports() {
  std::vector<std::uint16_t> out;
  (void)each_descriptor([&](int descriptor) {
    const auto port = shared_port(descriptor);
    if (port && std::ranges::find(out, *port) == out.end()) out.push_back(*port);
    return out.size() < kMaxPorts;
  });
  return out;
}

std::optional<bool> has_bound_udp() {
  bool is_bound = false;
  const bool are_told = each_descriptor([&](int descriptor) {
    is_bound = bound_port(descriptor).has_value();
    return !is_bound;
  });
  return are_told ? std::optional(is_bound) : std::nullopt;
}

// The file has one line for each address: 32 digits, the interface's index, the length of the
// prefix and the scope, all in hexadecimal. 20 means link scope.
std::vector<int> link_local_interfaces(std::string_view if_inet6) {
  std::vector<int> out;
  std::istringstream lines{std::string(if_inet6)};
  for (std::string line; std::getline(lines, line) && out.size() < kMaxInterfaces;) {
    std::istringstream words(line);
    std::string address, index, length, scope;
    words >> address >> index >> length >> scope;
    const auto interface = number_in<int>(index, 16);
    if (!interface || *interface <= 0 || scope != "20") continue;
    if (std::ranges::find(out, *interface) == out.end()) out.push_back(*interface);
  }
  return out;
}

void send_to_discovery(BytesView datagram) noexcept {
  try {
    const auto [groups, ports] = discovery_places();
    for (const auto port : ports)
      for (const auto& group : groups)
        send_one(datagram, {.is_ipv6 = group.is_ipv6, .port = port, .address = group.address},
                 group.interface);
  } catch (...) {
    // As declared, nothing is sent if memory is short.
  }
}

}  // namespace ddssec::cyclonedds
