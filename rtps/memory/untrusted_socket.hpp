// Descriptors that come from other processes, and sockets that other processes send to.
#pragma once

#include <cstdint>

#include "base/file_descriptor.hpp"

namespace ddssec::rtps::memory {

/// Closes a descriptor in another thread. Closing can take as long as another process wants: a file
/// of FUSE, or a TCP socket that lingers. So one thread of the process closes descriptors, and
/// starts when it is needed. If too many wait for it, the descriptor stays open. Never blocks.
void close_elsewhere(FileDescriptor descriptor);
/// True if eight descriptors or more wait for close_elsewhere or are being closed. Then no more
/// should be accepted from other processes.
bool closes_too_many();

/// A local socket to which another process may send descriptors. If a message is dropped, its
/// descriptors are closed, so a socket with messages is closed elsewhere.
class UntrustedSocket {
 public:
  explicit UntrustedSocket(FileDescriptor socket = FileDescriptor());
  ~UntrustedSocket();
  UntrustedSocket(UntrustedSocket&&) noexcept = default;
  UntrustedSocket& operator=(UntrustedSocket&& other) noexcept {
    std::swap(socket_, other.socket_);
    return *this;
  }
  explicit operator bool() const { return static_cast<bool>(socket_); }
  int number() const { return socket_.number(); }
  /// The next input, which is not removed. `octets` includes the end and an error.
  enum class Next : std::uint8_t { nothing, octets, descriptors };
  Next next() const;

 private:
  FileDescriptor socket_;
};

}  // namespace ddssec::rtps::memory
