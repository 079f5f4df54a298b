#include "rtps/transport/event_loop.hpp"

#include <netinet/in.h>
#include <thread>

#include <gmock/gmock.h>

namespace ddssec::rtps {
namespace {

TEST(EventLoop, SocketCallOrTime_WakesIt) {
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
