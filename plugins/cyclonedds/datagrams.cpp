#include "plugins/cyclonedds/datagrams.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <fstream>
#include <netinet/in.h>
#include <sstream>
#include <sys/socket.h>
#include <unistd.h>

namespace ddssec::cyclonedds {
namespace {

constexpr std::array<std::uint8_t, 4> kGroup{239, 255, 0, 1};

/// The address for the kernel and how long it is.
std::pair<sockaddr_storage, socklen_t> kernel_address(const spi::UdpAddress& address) {
  sockaddr_storage out{};
  if (address.is_ipv6) {
    sockaddr_in6 six{};
    six.sin6_family = AF_INET6;
    six.sin6_port = htons(address.port);
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

/// `interface`: an index, for multicast; 0: the system chooses.
void send_one(BytesView datagram, const spi::UdpAddress& to, int interface) noexcept {
  const int socket =
      ::socket(to.is_ipv6 ? AF_INET6 : AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (socket < 0) return;
  const auto [where, length] = kernel_address(to);
  ip_mreqn over{};
  over.imr_ifindex = interface;
  if (interface == 0 || ::setsockopt(socket, IPPROTO_IP, IP_MULTICAST_IF, &over, sizeof over) == 0)
    (void)::sendto(socket, datagram.data(), datagram.size(), MSG_NOSIGNAL,
                   reinterpret_cast<const sockaddr*>(&where), length);
  ::close(socket);
}

}  // namespace

void send_datagram(BytesView datagram, std::span<const spi::UdpAddress> to) noexcept {
  for (const auto& address : to) send_one(datagram, address, 0);
}

std::vector<int> interfaces_joined_to(std::string_view igmp,
                                      std::span<const std::uint8_t, 4> group) {
  constexpr std::size_t kMost = 64;
  // The kernel prints the four octets as one number of this machine.
  std::uint32_t wanted = 0;
  std::memcpy(&wanted, group.data(), 4);
  std::vector<int> out;
  std::istringstream lines{std::string(igmp)};
  int interface = 0;
  for (std::string line; std::getline(lines, line) && out.size() < kMost;) {
    if (line.empty()) continue;
    const bool is_group = line.front() == '\t' || line.front() == ' ';
    const auto begin = std::min(line.find_first_not_of(" \t"), line.size());
    std::uint32_t number = 0;
    const auto read =
        std::from_chars(line.data() + begin, line.data() + line.size(), number, is_group ? 16 : 10);
    if (read.ec != std::errc()) continue;
    if (!is_group)
      interface = static_cast<int>(number);
    else if (number == wanted && interface > 0)
      out.push_back(interface);
  }
  return out;
}

void send_to_discovery(BytesView datagram, DomainId domain) noexcept {
  constexpr std::uint32_t kBase = 7400, kPerDomain = 250;
  const auto port = kBase + kPerDomain * static_cast<std::uint32_t>(domain);
  if (port > 0xffff) return;
  spi::UdpAddress to{.port = static_cast<std::uint16_t>(port)};
  std::ranges::copy(kGroup, to.address.begin() + 12);
  try {
    std::ostringstream igmp;
    igmp << std::ifstream("/proc/self/net/igmp").rdbuf();
    for (const int interface : interfaces_joined_to(igmp.view(), kGroup))
      send_one(datagram, to, interface);
  } catch (...) {
    // As declared: without memory nothing is sent.
  }
}

}  // namespace ddssec::cyclonedds
