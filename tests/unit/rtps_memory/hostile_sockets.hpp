// What strangers send to local sockets.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstring>
#include <future>
#include <netinet/in.h>
#include <string>
#include <sys/socket.h>
#include <sys/un.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include "base/bytes.hpp"
#include "rtps/memory/descriptor_server.hpp"

namespace ddssec::rtps::memory::testing {

struct SocketAddress {
  explicit SocketAddress(const SocketName& name) {
    const std::string text = "ddssec-" + to_hex(name);
    octets.sun_family = AF_UNIX;
    std::memcpy(octets.sun_path + 1, text.data(), text.size());
    size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + text.size());
  }
  const sockaddr* generic() const {
    return static_cast<const sockaddr*>(static_cast<const void*>(&octets));
  }
  sockaddr_un octets{};
  socklen_t size = 0;
};

/// Returns a socket that is connected to `name` (SOCK_SEQPACKET), as an outsider opens it.
inline FileDescriptor connected(const SocketName& name) {
  FileDescriptor out(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const SocketAddress address(name);
  if (::connect(out.number(), address.generic(), address.size) != 0) return FileDescriptor();
  return out;
}

/// Sends one octet with these descriptors.
inline ssize_t send_with(const FileDescriptor& socket, const std::vector<int>& descriptors) {
  alignas(cmsghdr) std::array<char, CMSG_SPACE(64 * sizeof(int))> control{};
  char octet = 1;
  iovec part{.iov_base = &octet, .iov_len = 1};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  if (!descriptors.empty()) {
    const auto octets = descriptors.size() * sizeof(int);
    message.msg_control = control.data();
    message.msg_controllen = CMSG_SPACE(octets);
    cmsghdr* const head = CMSG_FIRSTHDR(&message);
    head->cmsg_level = SOL_SOCKET;
    head->cmsg_type = SCM_RIGHTS;
    head->cmsg_len = CMSG_LEN(octets);
    std::memcpy(CMSG_DATA(head), descriptors.data(), octets);
  }
  return ::sendmsg(socket.number(), &message, MSG_NOSIGNAL);
}

/// Listens in the place of a writer's process.
struct Impostor {
  explicit Impostor(MemoryId memory = {}, std::uint64_t segment = 7) {
    SystemRandom random;
    EXPECT_TRUE(random.fill(offer.name).has_value());
    offer.memory = memory;
    offer.segment = segment;
    const SocketAddress address(offer.name);
    EXPECT_EQ(::bind(listener.number(), address.generic(), address.size), 0);
    EXPECT_EQ(::listen(listener.number(), 1), 0);
  }
  /// Answers the request that waits or arrives.
  void answer(const std::vector<int>& descriptors) {
    socket = FileDescriptor(::accept4(listener.number(), nullptr, nullptr, SOCK_CLOEXEC));
    EXPECT_EQ(send_with(socket, descriptors), 1);
  }
  FileDescriptor listener{::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0)};
  FileDescriptor socket;
  DescriptorOffer offer{.token = *Token::copy_of(Bytes(32)), .process = ::getpid()};
};

/// A TCP socket with octets that the other side never reads, so its close waits for a minute.
struct SlowToClose {
  SlowToClose() {
    const FileDescriptor listener(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    auto* const generic = static_cast<sockaddr*>(static_cast<void*>(&address));
    socklen_t size = sizeof address;
    const int little = 4096;
    ::setsockopt(listener.number(), SOL_SOCKET, SO_RCVBUF, &little, sizeof little);
    EXPECT_EQ(::bind(listener.number(), generic, size), 0);
    EXPECT_EQ(::listen(listener.number(), 1), 0);
    EXPECT_EQ(::getsockname(listener.number(), generic, &size), 0);
    slow = FileDescriptor(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    EXPECT_EQ(::connect(slow.number(), generic, size), 0);
    other = FileDescriptor(::accept4(listener.number(), nullptr, nullptr, SOCK_CLOEXEC));
    const linger wait{.l_onoff = 1, .l_linger = 60};
    ::setsockopt(slow.number(), SOL_SOCKET, SO_LINGER, &wait, sizeof wait);
    // Sends until the other side accepts nothing more.
    const Bytes octets(1 << 16);
    for (int quiet = 0; quiet < 5; std::this_thread::sleep_for(std::chrono::milliseconds(1))) {
      ++quiet;
      while (::send(slow.number(), octets.data(), octets.size(), MSG_DONTWAIT) > 0) quiet = 0;
    }
  }
  /// Resets the connection, which ends the close.
  ~SlowToClose() {
    { const FileDescriptor last(other.release()); }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  /// Sends the descriptor, and closes our own. False if the receiver dropped it at once, so that
  /// our own close was the slow one.
  bool send_over(const FileDescriptor& socket) {
    EXPECT_EQ(send_with(socket, {slow.number()}), 1);
    auto closed = std::async(std::launch::async, [own = slow.release()] { ::close(own); });
    if (closed.wait_for(std::chrono::seconds(1)) == std::future_status::ready) return true;
    { const FileDescriptor reset(other.release()); }
    return false;
  }
  FileDescriptor slow, other;
};

/// Runs `f`, which must not wait for a socket that lingers.
template <class F>
void expect_quick(F&& f) {
  const auto before = std::chrono::steady_clock::now();
  f();
  EXPECT_LT(std::chrono::steady_clock::now() - before, std::chrono::seconds(5));
}

}  // namespace ddssec::rtps::memory::testing
