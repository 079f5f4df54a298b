#include "plugins/cyclonedds/datagrams.hpp"

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <gmock/gmock.h>

namespace ddssec::cyclonedds {
namespace {

TEST(SendDatagram, ReachesItsAddress) {
  const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in own{};
  own.sin_family = AF_INET;
  own.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof own;
  ASSERT_EQ(::bind(socket, reinterpret_cast<sockaddr*>(&own), length), 0);
  ASSERT_EQ(::getsockname(socket, reinterpret_cast<sockaddr*>(&own), &length), 0);
  const timeval patience{5, 0};
  ::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  spi::UdpAddress to{.port = ntohs(own.sin_port)};
  to.address[12] = 127;
  to.address[15] = 1;
  send_datagram(as_bytes("reset"), {&to, 1});
  char octets[16];
  EXPECT_EQ(::recv(socket, octets, sizeof octets, 0), 5);
  ::close(socket);
}

// As Linux 6.1 prints it on a little-endian machine.
constexpr std::string_view kIgmp =
    "Idx\tDevice    : Count Querier\tGroup    Users Timer\tReporter\n"
    "1\tlo        :     2      V3\n"
    "\t\t\t\t0100FFEF     2 0:00000000\t\t0\n"
    "\t\t\t\t010000E0     1 0:00000000\t\t0\n"
    "2\teth0      :     1      V3\n"
    "\t\t\t\t010000E0     1 0:00000000\t\t0\n"
    "17\tveth17    :     1      V2\n"
    "\t\t\t\t0100FFEF     1 0:00000000\t\t0\n";

TEST(SendToDiscovery, GoesWhereSomebodyListens) {
  constexpr std::array<std::uint8_t, 4> kGroup{239, 255, 0, 1}, kOther{239, 255, 0, 2};
  EXPECT_THAT(interfaces_joined_to(kIgmp, kGroup), ::testing::ElementsAre(1, 17));
  EXPECT_THAT(interfaces_joined_to(kIgmp, kOther), ::testing::IsEmpty());
  EXPECT_THAT(interfaces_joined_to("nonsense\n\t\tzz\n0100FFEF", kGroup), ::testing::IsEmpty());
}

}  // namespace
}  // namespace ddssec::cyclonedds
