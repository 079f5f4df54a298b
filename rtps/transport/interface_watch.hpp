// Reports when the network interfaces of this machine, or their addresses, change.
#pragma once

#include "rtps/transport/udp_socket.hpp"

namespace ddssec::rtps {

/// The system reports changes by a netlink socket (rtnetlink(7)). The messages are not read: after
/// a change, the caller reads the list of interfaces again.
class InterfaceWatch {
 public:
  /// Opens the socket. Errors: rtps_socket_failed, for example if a sandbox forbids such sockets.
  static Result<InterfaceWatch> open();

  /// Returns the socket, which is readable after a change.
  int fd() const { return socket_.number(); }
  /// Returns true if anything has changed since the last call.
  bool drain() const;

 private:
  explicit InterfaceWatch(FileDescriptor socket) : socket_(std::move(socket)) {}

  FileDescriptor socket_;
};

}  // namespace ddssec::rtps
