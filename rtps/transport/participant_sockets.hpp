// The sockets of one participant, at its well-known ports (RTPS 9.6.2).
#pragma once

#include <functional>
#include <optional>

#include "rtps/transport/event_loop.hpp"
#include "rtps/transport/host_sockets.hpp"
#include "rtps/transport/network_interfaces.hpp"
#include "rtps/transport/ports.hpp"
#include "rtps/transport/transport.hpp"
#include "rtps/transport/udp_socket.hpp"

namespace ddssec::rtps {

/// The sockets are one for discovery, one for user data, one for a multicast group, and one for
/// each further interface, through which messages to the group are sent. The discovery socket sends
/// everything else. HostSockets send the datagrams for which its send buffer has no room.
class ParticipantSockets final : public Transport {
 public:
  struct Options {
    /// The size to request from the system, in octets.
    std::size_t receive_buffer = UdpSocket::kWantedBuffer;
    /// If false, sockets of the loopback alone cannot be reached from other machines, and `use`
    /// cannot replace it.
    bool interfaces_may_change = false;
  };
  /// Opens the ports of the first participant index for which both are free. Errors:
  /// rtps_port_taken (all indexes), those of EventLoop::create and UdpSocket.
  static Result<std::unique_ptr<ParticipantSockets>> open(DomainId domain,
                                                          std::vector<NetworkInterface> interfaces,
                                                          const Options& options);

  /// Returns the participant index.
  int index() const { return index_; }
  const std::vector<NetworkInterface>& interfaces() const { return interfaces_; }
  /// Returns the addresses at which the sockets can be reached, on all interfaces.
  LocatorList metatraffic() const { return everywhere(sockets_[0].local().port); }
  LocatorList user() const { return everywhere(sockets_[1].local().port); }
  /// Checks the receive buffer of the socket for user data (UdpSocket::check_receive_buffer).
  Status check_receive_buffer() const { return sockets_[1].check_receive_buffer(); }

  /// Joins a multicast group on one of the interfaces. Errors: rtps_no_multicast, those of
  /// UdpSocket::everywhere.
  Status join(const Locator& group, const NetworkInterface& interface);
  bool has_joined() const { return sockets_.size() > kWithoutGroup; }
  /// Uses these interfaces from now on, also for the group that it joined, because the interfaces
  /// of this machine have changed. If they are the same ones as before, they were gone and are
  /// back. Returns an error for each interface that cannot be used for the group.
  std::vector<Error> use(std::vector<NetworkInterface> interfaces);

  /// Calls `f(socket)` whenever a socket is readable from now on. Errors: those of
  /// EventLoop::watch.
  Status listen(std::function<void(UdpSocket&)> f);
  EventLoop& loop() { return loop_; }

  void send(BytesView message, std::span<const Locator> to) override;
  /// Messages to an address follow the routing table. Messages to a group are sent through each
  /// interface, or through the one that `out` names.
  void send_all(const OutgoingMessages& out) override;
  bool stays_here(const Locator& to) const override;

 private:
  static constexpr std::size_t kWithoutGroup = 2;

  ParticipantSockets(EventLoop loop, std::vector<NetworkInterface> interfaces, int index,
                     const Options& options)
      : loop_(std::move(loop)), interfaces_(std::move(interfaces)), index_(index) {
    overflow_ = HostSockets([this, options] { return socket_at(interfaces_, 0, options); });
    sockets_.reserve(kWithoutGroup + 1);  // the handlers refer to the sockets in it
  }
  static Result<UdpSocket> socket_at(std::span<const NetworkInterface> interfaces,
                                     std::uint32_t port, const Options& options);
  /// Makes messages to the group be sent through this interface as well.
  Status send_by(const NetworkInterface& interface);
  void send_first(const OutgoingMessages& out);
  bool leaves_by(const UdpSocket& socket, std::size_t interface) const;
  LocatorList everywhere(std::uint32_t port) const;

  EventLoop loop_;
  std::vector<NetworkInterface> interfaces_;
  const int index_;
  std::vector<UdpSocket> sockets_, further_;
  std::optional<Locator> group_;
  HostSockets overflow_{nullptr};
  std::function<void(UdpSocket&)> receive_;
};

}  // namespace ddssec::rtps
