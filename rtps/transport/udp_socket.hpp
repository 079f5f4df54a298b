// One UDP socket, IPv4 or IPv6, that receives and sends in batches.
#pragma once

#include <functional>
#include <memory>
#include <span>

#include "base/bytes.hpp"
#include "base/file_descriptor.hpp"
#include "base/result.hpp"
#include "rtps/transport/transport.hpp"

namespace ddssec::rtps {

/// One UDP socket. Receiving is not thread-safe; sending is safe from any thread.
class UdpSocket {
 public:
  static constexpr std::size_t kMaxDatagram = 65507;
  static constexpr std::size_t kBatch = 16;

  /// The receive buffer that large samples need, in octets: the octets that a writer sends before
  /// it waits (StatefulWriter::is_ahead), plus the kernel's overhead for them.
  static constexpr std::size_t kNeededBuffer = std::size_t{1} << 20;
  static constexpr std::size_t kWantedBuffer = std::size_t{4} << 20;

  /// Binds a socket to the address and port of `at`; port 0 selects one. `buffer` is the size to
  /// request from the system, in octets. Errors: rtps_port_taken, rtps_address_not_here,
  /// rtps_socket_failed.
  static Result<UdpSocket> bind(const Locator& at, std::size_t buffer = kWantedBuffer);
  /// Creates a socket that can be reached at the port of `interface` by every address of this
  /// machine. Peers on it may use another address than the announced one (Fast DDS 2.9: loopback).
  /// `local` and multicast use `interface`. If `interface` is the loopback, the socket is bound to
  /// it alone. Errors: those of bind.
  static Result<UdpSocket> on_interface(const Locator& interface,
                                        std::size_t buffer = kWantedBuffer);
  /// As on_interface, but even if `interface` is the loopback, the socket can be reached by every
  /// address: for a participant that uses several interfaces.
  static Result<UdpSocket> everywhere(const Locator& interface, std::size_t buffer = kWantedBuffer);
  /// Creates a socket bound to the port of `group` and joins the group on the interface with
  /// address `interface`. Errors: those of bind, and rtps_no_multicast.
  static Result<UdpSocket> join(const Locator& group, const Locator& interface);
  /// Makes the socket also receive messages to `group` that arrive on another interface. Errors:
  /// rtps_no_multicast.
  Status join_also(const Locator& group, const Locator& interface);
  /// Leaves the group on that interface, even if the interface is gone.
  void leave(const Locator& group, const Locator& interface) const;
  /// Makes `local` and multicast use the interface with this address. For a socket that can be
  /// reached by every address. Errors: rtps_address_not_here, rtps_socket_failed.
  Status use(const Locator& interface);

  /// Makes the kernel keep almost nothing that arrives, for a socket that only sends.
  void keep_no_input() const;

  int fd() const { return fd_.number(); }
  const Locator& local() const { return local_; }
  /// Returns the buffer that the system granted, in octets.
  std::size_t receive_buffer_size() const;
  /// Checks that the buffer is large enough for large samples. Errors: rtps_receive_buffer_small.
  Status check_receive_buffer() const;

  /// Passes each waiting datagram to `f(datagram, source)`, at most kBatch, and returns their
  /// number. The datagram is valid during the call.
  template <class F>
  std::size_t receive(F&& f) {
    const auto count = fetch();
    for (std::size_t i = 0; i < count; ++i) f(datagram(i), source(i));
    return count;
  }

  /// Receives the waiting datagrams, at most kBatch, and returns their number. They are valid until
  /// the next call.
  std::size_t fetch();
  BytesView datagram(std::size_t index) const;
  /// Returns the address that the datagram came from.
  Locator source(std::size_t index) const;

  /// Takes a datagram for which the send buffer had no room.
  using Unsent = std::function<void(BytesView message, const Locator& to)>;
  /// Sends to each locator of this socket's family, kBatch datagrams with each system call. Without
  /// `unsent`, datagrams for which the send buffer has no room are lost.
  void send_all(const OutgoingMessages& out, const Unsent& unsent = nullptr) const;
  void send(BytesView message, std::span<const Locator> to) const { send_all({{&message, 1}, to}); }

 private:
  struct Batch;
  class SendCall;
  struct BatchDelete {
    void operator()(Batch* batch) const noexcept;
  };
  UdpSocket(FileDescriptor fd, const Locator& local);
  static Result<UdpSocket> open(const Locator& at, bool shared, std::size_t buffer);

  FileDescriptor fd_;
  Locator local_;
  std::unique_ptr<Batch, BatchDelete> batch_;
};

}  // namespace ddssec::rtps
