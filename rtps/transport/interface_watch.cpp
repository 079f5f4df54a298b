#include "rtps/transport/interface_watch.hpp"

#include <array>
#include <cerrno>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <sys/socket.h>

#include "base/errno_text.hpp"

namespace ddssec::rtps {

Result<InterfaceWatch> InterfaceWatch::open() {
  const auto watch_error = [](const char* call) {
    return fail(
        Code::rtps_socket_failed,
        {.document = "changes of network interfaces", .field = call, .found = errno_text(errno)});
  };
  FileDescriptor fd(::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, NETLINK_ROUTE));
  if (fd.number() < 0) return watch_error("socket");
  sockaddr_nl address{};
  address.nl_family = AF_NETLINK;
  address.nl_groups = RTMGRP_LINK | RTMGRP_IPV4_IFADDR | RTMGRP_IPV6_IFADDR;
  if (::bind(fd.number(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    return watch_error("bind");
  return InterfaceWatch(std::move(fd));
}

// If a message had no room in the socket, recv() fails once (ENOBUFS). That counts as a change as
// well.
bool InterfaceWatch::drain() const {
  constexpr int kMax = 64;
  std::array<std::uint8_t, 8192> ignored;
  int count = 0;
  while (count < kMax && (::recv(fd(), ignored.data(), ignored.size(), 0) >= 0 || errno == ENOBUFS))
    ++count;
  return count > 0;
}

}  // namespace ddssec::rtps
