// Descriptors that come from other processes, and sockets that other processes send to.
#pragma once

#include <cstdint>

#include "base/file_descriptor.hpp"

namespace ddssec::rtps::memory {

/// To close a descriptor can take as long as another process likes: a file of FUSE, or a TCP socket
/// that lingers. So one thread of the process closes them, which starts when it is needed. If too
/// many wait for it, the descriptor stays open. Never blocks.
void close_elsewhere(FileDescriptor descriptor);
/// So many wait that no more should be taken from other processes.
bool closes_too_many();

/// A local socket to which another process may send descriptors. To drop a message closes
/// what is in it, so a socket with messages is closed elsewhere.
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
  /// What is there to be received, and stays there. `octets`: also the end, or an error.
  enum class Next : std::uint8_t { nothing, octets, descriptors };
  Next next() const;

 private:
  FileDescriptor socket_;
};

}  // namespace ddssec::rtps::memory
