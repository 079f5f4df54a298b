#include "plugins/cyclonedds/datagrams.hpp"

#include <algorithm>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <gmock/gmock.h>

namespace ddssec::cyclonedds {
namespace {

TEST(SendDatagram, GivenAddress_ReceivesIt) {
  const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in own{};
  own.sin_family = AF_INET;
  own.sin_addr.s_addr = htonl(INADDR_LOOPBACK + 1);
  socklen_t length = sizeof own;
  ASSERT_EQ(::bind(socket, reinterpret_cast<sockaddr*>(&own), length), 0);
  ASSERT_EQ(::getsockname(socket, reinterpret_cast<sockaddr*>(&own), &length), 0);
  const timeval patience{5, 0};
  ::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  spi::UdpAddress to{.port = ntohs(own.sin_port)};
  to.address[12] = 127;
  to.address[15] = 2;
  send_datagram(as_bytes("reset"), {&to, 1});
  char octets[16];
  EXPECT_EQ(::recv(socket, octets, sizeof octets, 0), 5);
  ::close(socket);
}

// The format of Linux 6.1 on a little-endian machine.
constexpr std::string_view kIgmp =
    "Idx\tDevice    : Count Querier\tGroup    Users Timer\tReporter\n"
    "1\tlo        :     2      V3\n"
    "\t\t\t\t0100FFEF     2 0:00000000\t\t0\n"
    "\t\t\t\t010000E0     1 0:00000000\t\t0\n"
    "2\teth0      :     1      V3\n"
    "\t\t\t\t010000E0     1 0:00000000\t\t0\n"
    "\t\t\t\tFB0000E0     1 0:00000000\t\t0\n"
    "17\tveth17    :     1      V2\n"
    "\t\t\t\t0900FFEF     1 0:00000000\t\t0\n";
constexpr std::string_view kIgmp6 =
    "1    lo              ff0200000000000000000000000000fb     1 00000004 0\n"
    "4    eth0            ff02000000000000000000ffefff0001     1 00000004 0\n"
    "4    eth0            ff020000000000000000ffffefff0001     1 00000004 0\n"
    "4    eth0            ff020000000000000000000001ff000a     1 00000004 0\n"
    "4    eth0            ff0200000000000000000001ff020057     1 00000004 0\n"
    "4    eth0            ff020000000000000000000000000001     1 0000000C 0\n";

JoinedGroup group(int interface, std::initializer_list<std::uint8_t> end, bool is_ipv6 = false) {
  JoinedGroup out{.interface = interface, .is_ipv6 = is_ipv6};
  if (is_ipv6) out.address = {0xff, 0x02};
  std::ranges::copy(end, out.address.end() - static_cast<std::ptrdiff_t>(end.size()));
  return out;
}

TEST(JoinedGroups, EachGroup_IsListedExceptThoseOfLocalProtocols) {
  EXPECT_THAT(joined_groups(kIgmp, ""),
              ::testing::ElementsAre(group(1, {239, 255, 0, 1}), group(17, {239, 255, 0, 9})));
  EXPECT_THAT(joined_groups("", kIgmp6),
              ::testing::Contains(group(4, {0xff, 0xff, 239, 255, 0, 1}, true)));
  EXPECT_THAT(joined_groups("", kIgmp6),
              ::testing::Not(::testing::Contains(group(4, {0, 1, 0xff, 2, 0, 0x57}, true))));
  EXPECT_THAT(joined_groups("", kIgmp6), ::testing::Not(::testing::Contains(group(4, {1}, true))));
}

TEST(JoinedGroups, Nonsense_GivesNone) {
  EXPECT_THAT(joined_groups("nonsense\n\t\tzz\n0100FFEF",
                            "4 eth0 ff02\n4 eth0 ff020000000000000000ffffefff00zz"),
              ::testing::IsEmpty());
}

// A socket that is bound to a port of the system's choice.
class Socket {
 public:
  explicit Socket(bool is_shared) : socket_(::socket(AF_INET, SOCK_DGRAM, 0)) {
    const int on = is_shared ? 1 : 0;
    ::setsockopt(socket_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    sockaddr_in own{};
    own.sin_family = AF_INET;
    socklen_t length = sizeof own;
    ::bind(socket_, reinterpret_cast<sockaddr*>(&own), length);
    ::getsockname(socket_, reinterpret_cast<sockaddr*>(&own), &length);
    port_ = ntohs(own.sin_port);
  }
  ~Socket() { ::close(socket_); }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  std::uint16_t port() const { return port_; }

 private:
  int socket_;
  std::uint16_t port_ = 0;
};

TEST(BoundUdp, SocketWithAPort_IsFound) {
  ASSERT_EQ(has_bound_udp(), false);
  const int unbound = ::socket(AF_INET, SOCK_DGRAM, 0), tcp = ::socket(AF_INET, SOCK_STREAM, 0);
  EXPECT_EQ(has_bound_udp(), false);
  const Socket bound(false);
  EXPECT_EQ(has_bound_udp(), true);
  ::close(unbound);
  ::close(tcp);
}

// The format of Linux 6.1.
TEST(LinkLocalInterfaces, AddressOfThatScope_ListsItsInterface) {
  constexpr std::string_view kAddresses =
      "00000000000000000000000000000001 01 80 10 80       lo\n"
      "fe80000000000000f03c91fffe2a1b3c 02 40 20 80     eth0\n"
      "20010db8000000000000000000000001 02 40 00 80     eth0\n"
      "fe800000000000000042a1fffe2a1b3c 02 40 20 80     eth0\n"
      "fe800000000000000042a1fffe2a1b3c 1f 40 20 80 docker0\n";
  EXPECT_THAT(link_local_interfaces(kAddresses), ::testing::ElementsAre(2, 31));
  EXPECT_THAT(link_local_interfaces("nonsense\nfe80 zz 40 20\nfe80 00 40 20 80 x\n\n"),
              ::testing::IsEmpty());
  std::string many;
  for (int i = 1; i < 40; ++i) many += "fe80 " + std::to_string(i) + " 40 20 80 x\n";
  EXPECT_EQ(link_local_interfaces(many).size(), 16u);
}

TEST(SharedPorts, PortThatOthersMayBindToo_IsListed) {
  const Socket shared(true), alone(false);
  const auto ports = shared_ports();
  EXPECT_THAT(ports, ::testing::Contains(shared.port()));
  EXPECT_THAT(ports, ::testing::Not(::testing::Contains(alone.port())));
}

}  // namespace
}  // namespace ddssec::cyclonedds
