// Sockets: what they send and receive, and what the system refuses.
#include "rtps/transport/udp_socket.hpp"

#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <thread>

#include <gmock/gmock.h>

#include "rtps/transport/event_loop.hpp"
#include "rtps/transport/network_interfaces.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"

namespace ddssec::rtps {
namespace {

using testing::code_of;

TEST(UdpSocket, ManyDestinations_GetEachAndReceiveInBatches) {
  const auto loopback = *Locator::parse("127.0.0.1", 0);
  auto a = *UdpSocket::bind(loopback);
  auto b = *UdpSocket::bind(loopback);
  auto from = *UdpSocket::bind(loopback);
  const Locator to[] = {a.local(), *Locator::parse("::1", 9), b.local()};
  from.send(as_bytes("one"), to);
  from.send(as_bytes("two"), to);
  for (auto* socket : {&a, &b}) {
    std::string seen;
    while (seen.size() < 6)
      socket->receive([&](BytesView datagram, const Locator& source) {
        EXPECT_EQ(source, from.local());
        seen += as_text(datagram);
      });
    EXPECT_EQ(seen, "onetwo");
  }
  EXPECT_GT(a.receive_buffer_size(), 10'000u);
}

TEST(UdpSocket, ATakenPort_IsNamed) {
  const auto first = *UdpSocket::bind(*Locator::parse("127.0.0.1", 0));
  const auto second = UdpSocket::bind(first.local());
  ASSERT_EQ(code_of(second), Code::rtps_port_taken);
  EXPECT_EQ(second.error().details().document, to_string(first.local()));
}

TEST(UdpSocket, AnAddressThatIsNotOurs_IsRefused) {
  const auto foreign = *Locator::parse("192.0.2.1", 0);
  EXPECT_EQ(code_of(UdpSocket::bind(foreign)), Code::rtps_address_not_here);
  EXPECT_EQ(code_of(UdpSocket::on_interface(foreign)), Code::rtps_address_not_here);
}

TEST(UdpSocket, OnAnInterface_IsReachedByLoopbackTooAndShowsTheInterface) {
  const auto address = choose_interfaces({})->front().address;
  auto socket = *UdpSocket::on_interface(address);
  EXPECT_EQ(socket.local().address, address.address);
  EXPECT_NE(socket.local().port, 0u);
  auto from = *UdpSocket::bind(*Locator::parse("127.0.0.1", 0));
  auto near = *Locator::parse("127.0.0.1", 0);
  near.port = socket.local().port;
  from.send(as_bytes("one"), std::span(&near, 1));
  std::size_t came = 0;
  for (int i = 0; i < 1000 && came == 0; ++i) {
    came = socket.receive([](BytesView octets, const Locator&) { EXPECT_EQ(octets.size(), 3u); });
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(came, 1u);
}

TEST(UdpSocket, ManyMessagesToMany_LeaveInOrder) {
  const auto loopback = *Locator::parse("127.0.0.1", 0);
  auto a = *UdpSocket::bind(loopback), b = *UdpSocket::bind(loopback);
  const auto from = *UdpSocket::bind(loopback);
  std::vector<std::string> texts;
  std::vector<BytesView> messages;
  for (int i = 0; i < 21; ++i) texts.push_back(std::to_string(i) + " ");
  for (const auto& text : texts) messages.push_back(as_bytes(text));
  const Locator to[] = {a.local(), b.local()};
  from.send_all({messages, to});
  for (auto* socket : {&a, &b}) {
    std::string seen;
    while (seen.size() < 53)
      socket->receive([&](BytesView datagram, const Locator&) { seen += as_text(datagram); });
    EXPECT_EQ(seen, "0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 ");
  }
}

// Returns the traffic class of the next datagram.
int traffic_class_at(const UdpSocket& socket, int type) {
  std::array<std::uint8_t, 64> octets;
  alignas(cmsghdr) std::array<std::uint8_t, 64> control{};
  iovec vector{octets.data(), octets.size()};
  msghdr header{};
  header.msg_iov = &vector;
  header.msg_iovlen = 1;
  header.msg_control = control.data();
  header.msg_controllen = control.size();
  while (::recvmsg(socket.fd(), &header, 0) < 0) {
    if (errno != EAGAIN) return -1;
  }
  for (auto* at = CMSG_FIRSTHDR(&header); at != nullptr; at = CMSG_NXTHDR(&header, at))
    if (at->cmsg_type == type) return at->cmsg_len > CMSG_LEN(0) ? *CMSG_DATA(at) : -1;
  return -1;
}

TEST(UdpSocket, APriority_IsTheTrafficClassOfItsDatagrams) {
  struct Family {
    const char* address;
    int level, option, type;
  };
  for (const auto& family : {Family{"127.0.0.1", IPPROTO_IP, IP_RECVTOS, IP_TOS},
                             Family{"::1", IPPROTO_IPV6, IPV6_RECVTCLASS, IPV6_TCLASS}}) {
    const auto to = UdpSocket::bind(*Locator::parse(family.address, 0));
    if (!to) continue;  // this machine has no IPv6
    const auto from = *UdpSocket::bind(*Locator::parse(family.address, 0));
    const int on = 1;
    ASSERT_EQ(::setsockopt(to->fd(), family.level, family.option, &on, sizeof on), 0);
    const auto message = as_bytes("x");
    const Locator locators[] = {to->local()};
    for (std::uint8_t dscp : {46, 0, 63}) {
      from.send_all({{&message, 1}, locators, dscp});
      EXPECT_EQ(traffic_class_at(*to, family.type), dscp << 2);
    }
  }
}

TEST(UdpSocket, ASmallReceiveBuffer_IsSaidWithItsRemedy) {
  const auto small = *UdpSocket::bind(*Locator::parse("127.0.0.1", 0), 64 << 10);
  const auto checked = small.check_receive_buffer();
  ASSERT_EQ(code_of(checked), Code::rtps_receive_buffer_small);
  EXPECT_EQ(checked.error().details().found, "65536 octets");
  EXPECT_THAT(checked.error().to_sentence(),
              ::testing::HasSubstr("sysctl -w net.core.rmem_max=4194304"));
}

TEST(UdpSocket, AGroupThatCannotBeJoined_IsNamed) {
  const auto group = *Locator::parse("239.255.0.1", 7400);
  const auto joined = UdpSocket::join(group, *Locator::parse("::1", 0));
  ASSERT_EQ(code_of(joined), Code::rtps_no_multicast);
  EXPECT_THAT(joined.error().to_sentence(), ::testing::HasSubstr("peers"));
}

TEST(UdpSocket, WhatTheSystemRefuses_IsNamed) {
  // A sanitizer needs descriptors when it looks at an error's type for the first time. Here it
  // still has them.
  ASSERT_FALSE(UdpSocket::join(*Locator::parse("239.255.0.1", 7400), *Locator::parse("::1", 0)));
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  const rlimit none{0, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
  const auto code = code_of(UdpSocket::bind(*Locator::parse("127.0.0.1", 0)));
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  EXPECT_EQ(code, Code::rtps_socket_failed);
}

}  // namespace
}  // namespace ddssec::rtps
