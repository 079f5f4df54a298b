// Datagrams to IPv6 link-local addresses, in a network namespace with two links. Needs root or user
// namespaces (sysctl kernel.unprivileged_userns_clone), and ip of iproute2.
#include <algorithm>
#include <array>
#include <cstdlib>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/socket.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "plugins/cyclonedds/datagrams.hpp"

namespace ddssec::cyclonedds {
namespace {

constexpr const char* kTwoLinks =
    "ip link set lo up && for l in d a; do ip link add ${l}0 type veth peer name ${l}1 && "
    "ip link set ${l}0 addrgenmode none && ip link set ${l}1 addrgenmode none && "
    "ip link set ${l}0 up && ip link set ${l}1 up && ip addr add fe80::1/64 dev ${l}0 nodad || "
    "exit 1; done";

// Receives everything that arrives at an interface.
class Wire {
 public:
  explicit Wire(const char* interface)
      : socket_(::socket(AF_PACKET, SOCK_DGRAM | SOCK_CLOEXEC, htons(ETH_P_IPV6))) {
    sockaddr_ll own{};
    own.sll_family = AF_PACKET;
    own.sll_protocol = htons(ETH_P_IPV6);
    own.sll_ifindex = static_cast<int>(::if_nametoindex(interface));
    EXPECT_EQ(::bind(socket_, reinterpret_cast<sockaddr*>(&own), sizeof own), 0);
    const timeval patience{2, 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  }
  ~Wire() { ::close(socket_); }
  Wire(const Wire&) = delete;
  Wire& operator=(const Wire&) = delete;

  // True if a neighbor solicitation on this link asks for the owner of the address.
  bool hears_question_for(const std::array<std::uint8_t, 16>& address) const {
    constexpr std::size_t kTargetAt = 48;
    std::array<std::uint8_t, 2000> packet{};
    for (;;) {
      const auto size = ::recv(socket_, packet.data(), packet.size(), 0);
      if (size < 0) return false;
      if (static_cast<std::size_t>(size) < kTargetAt + 16 || packet[40] != 135) continue;
      if (std::equal(address.begin(), address.end(), packet.begin() + kTargetAt)) return true;
    }
  }

 private:
  int socket_;
};

TEST(SendLinkLocalDatagram, LinkLocalAddress_IsReachedOverEachLink) {
  ASSERT_EQ(::unshare(::geteuid() == 0 ? CLONE_NEWNET : CLONE_NEWUSER | CLONE_NEWNET), 0);
  ASSERT_EQ(std::system(kTwoLinks), 0);
  const Wire first("d1"), second("a1");
  const spi::UdpAddress to{.is_ipv6 = true,
                           .port = 7410,
                           .address = {0xfe, 0x80, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x12, 0x34}};
  send_datagram(as_bytes("reset"), {&to, 1});
  EXPECT_TRUE(first.hears_question_for(to.address));
  EXPECT_TRUE(second.hears_question_for(to.address));
}

}  // namespace
}  // namespace ddssec::cyclonedds
