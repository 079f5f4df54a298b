// One UDP socket, IPv4 or IPv6, that receives and sends in batches.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "rtps/transport/transport.hpp"

namespace ddssec::rtps {

/// Closes itself.
class FileDescriptor {
 public:
  explicit FileDescriptor(int fd = -1) : fd_(fd) {}
  ~FileDescriptor();
  FileDescriptor(FileDescriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  int value() const { return fd_; }

 private:
  int fd_;
};

/// Not thread-safe for receiving; sending is safe from any thread.
class UdpSocket {
 public:
  static constexpr std::size_t kLargestDatagram = 65507;
  static constexpr std::size_t kBatch = 16;

  /// Octets of the receive buffer that large samples need: what a writer sends before it waits
  /// (StatefulWriter::is_ahead), and the kernel's book-keeping for it.
  static constexpr std::size_t kNeededBuffer = std::size_t{1} << 20;
  static constexpr std::size_t kWantedBuffer = std::size_t{4} << 20;

  /// Bound to the address and port of `at`; port 0 chooses one. `buffer`: octets to ask the system
  /// for. Errors: rtps_port_taken, rtps_address_not_here, rtps_socket_failed.
  static Result<UdpSocket> bind(const Locator& at, std::size_t buffer = kWantedBuffer);
  /// Reachable at the port of `interface` by every address of this machine, as peers on it may use
  /// another one than they were told (Fast DDS 2.9: loopback); `local` and multicast are those of
  /// `interface`. On loopback: bound to it alone. Errors: as bind.
  static Result<UdpSocket> on_interface(const Locator& interface,
                                        std::size_t buffer = kWantedBuffer);
  /// The same, and if `interface` is the loopback still reachable by every address: for a
  /// participant that uses several interfaces.
  static Result<UdpSocket> everywhere(const Locator& interface, std::size_t buffer = kWantedBuffer);
  /// Bound to the port of `group` and joined to it on the interface with address `interface`.
  /// Errors besides: rtps_no_multicast.
  static Result<UdpSocket> join(const Locator& group, const Locator& interface);
  /// Receives what comes to `group` by another interface too. Errors: rtps_no_multicast.
  Status join_also(const Locator& group, const Locator& interface);

  int fd() const { return fd_.value(); }
  const Locator& local() const { return local_; }
  /// What the system granted, in octets.
  std::size_t receive_buffer_size() const;
  /// rtps_receive_buffer_small if large samples need more.
  Status check_receive_buffer() const;

  /// Passes each datagram that waits to `f(datagram, source)`, at most kBatch; returns how many.
  /// The datagram is valid during the call.
  template <class F>
  std::size_t receive(F&& f) {
    const auto count = fetch();
    for (std::size_t i = 0; i < count; ++i) f(datagram(i), source(i));
    return count;
  }

  /// Takes what waits, at most kBatch datagrams; returns how many. They are valid until the next
  /// call.
  std::size_t fetch();
  BytesView datagram(std::size_t index) const;
  /// Where it came from.
  Locator source(std::size_t index) const;

  /// To each locator of this socket's family, kBatch datagrams a system call.
  void send_all(const Outgoing& out) const;
  void send(BytesView message, std::span<const Locator> to) const { send_all({{&message, 1}, to}); }

 private:
  struct Batch;
  class Sending;
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
