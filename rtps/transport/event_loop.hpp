// Waits for sockets, a point in time or a call, in a thread of its own or in the caller's.
#pragma once

#include <chrono>
#include <functional>
#include <vector>

#include "rtps/transport/udp_socket.hpp"

namespace ddssec::rtps {

class EventLoop {
 public:
  /// Errors: rtps_socket_failed.
  static Result<EventLoop> create();

  /// Calls `on_readable` from `wait` whenever `fd` has something to read.
  Status watch(int fd, std::function<void()> on_readable);
  /// Waits at most `timeout` (negative: for ever) and serves what is readable.
  void wait(std::chrono::nanoseconds timeout);
  /// Ends a `wait`, from any thread.
  void wake() const;

 private:
  EventLoop(FileDescriptor epoll, FileDescriptor wake_up)
      : epoll_(std::move(epoll)), wake_up_(std::move(wake_up)) {}

  FileDescriptor epoll_;
  FileDescriptor wake_up_;
  std::vector<std::function<void()>> handlers_;
};

}  // namespace ddssec::rtps
