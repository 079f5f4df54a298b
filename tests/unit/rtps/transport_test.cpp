#include <thread>

#include "rtps/transport/event_loop.hpp"
#include "rtps/transport/interfaces.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"

namespace ddssec::rtps {
namespace {

using testing::code_of;

TEST(UdpSocket, SendsToManyAndReceivesInBatches) {
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

TEST(UdpSocket, ATakenPortIsNamed) {
  const auto first = *UdpSocket::bind(*Locator::parse("127.0.0.1", 0));
  const auto second = UdpSocket::bind(first.local());
  ASSERT_EQ(code_of(second), Code::rtps_port_taken);
  EXPECT_EQ(second.error().details().document, to_string(first.local()));
}

TEST(UdpSocket, AnAddressThatIsNotOursIsRefused) {
  const auto foreign = *Locator::parse("192.0.2.1", 0);
  EXPECT_EQ(code_of(UdpSocket::bind(foreign)), Code::rtps_socket_failed);
  EXPECT_EQ(code_of(UdpSocket::on_interface(foreign)), Code::rtps_socket_failed);
}

TEST(DefaultInterface, IsAnAddressToBindTo) {
  const auto address = Locator::parse(default_interface(), 0);
  ASSERT_TRUE(address);
  EXPECT_EQ(address->kind, LocatorKind::udp_v4);
  EXPECT_TRUE(UdpSocket::bind(*address));
}

TEST(UdpSocket, OnAnInterfaceIsReachedByLoopbackTooAndShowsTheInterface) {
  const auto address = *Locator::parse(default_interface(), 0);
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

TEST(EventLoop, WakesForASocketForACallAndForTime) {
  auto loop = *EventLoop::create();
  auto socket = *UdpSocket::bind(*Locator::parse("127.0.0.1", 0));
  int readable = 0;
  ASSERT_TRUE(loop.watch(socket.fd(), [&] {
    ++readable;
    socket.receive([](BytesView, const Locator&) {});
  }));
  loop.wait(std::chrono::milliseconds(1));
  EXPECT_EQ(readable, 0);
  const Locator to[] = {socket.local()};
  socket.send(as_bytes("x"), to);
  loop.wait(std::chrono::seconds(5));
  EXPECT_EQ(readable, 1);
  std::thread waker([&] { loop.wake(); });
  loop.wait(std::chrono::seconds(-1));
  waker.join();
}

}  // namespace
}  // namespace ddssec::rtps
