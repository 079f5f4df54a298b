// Sockets that each send to one host, for when the send buffer of a shared socket is full.
#pragma once

#include <list>

#include "rtps/transport/udp_socket.hpp"

namespace ddssec::rtps {

/// Datagrams to an address without a machine wait in the kernel for about three seconds and count
/// for the send buffer of their socket. In a shared socket they leave no room for other hosts. Here
/// each host has a send buffer of its own. Not thread-safe.
class HostSockets {
 public:
  /// The largest number of hosts. If there are more, the host that was sent to longest ago loses
  /// its socket.
  static constexpr std::size_t kMax = 32;
  using Open = std::function<Result<UdpSocket>()>;
  explicit HostSockets(Open open) : open_(std::move(open)) {}

  /// Sends a datagram. It is lost if the host's own send buffer is full.
  void send(BytesView message, const Locator& to, std::uint8_t dscp);
  std::size_t size() const { return hosts_.size(); }

 private:
  struct Host {
    Locator address;  ///< without a port
    UdpSocket socket;
  };
  /// Returns nullptr if no socket can be opened.
  UdpSocket* socket_of(Locator address);

  Open open_;
  std::list<Host> hosts_;  ///< the host that was sent to last is at the front
};

}  // namespace ddssec::rtps
