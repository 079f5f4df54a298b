// Waits for sockets, a time or a wake-up, in a thread of its own or in the caller's thread.
#pragma once

#include <array>
#include <chrono>
#include <functional>
#include <sys/epoll.h>
#include <vector>

#include "rtps/transport/udp_socket.hpp"

namespace ddssec::rtps {

/// One epoll instance. Only wake() may be called from other threads.
class EventLoop {
 public:
  /// Creates a loop that waits for nothing yet. Errors: rtps_socket_failed.
  static Result<EventLoop> create();

  /// Makes `wait` call `on_readable` whenever `fd` is readable. Errors: rtps_socket_failed.
  Status watch(int fd, std::function<void()> on_readable);
  /// Makes `wait` first look for readable sockets again and again, for this long.
  void busy_wait(std::chrono::nanoseconds how_long) { busy_wait_ = how_long; }
  /// The sockets that are readable. They remain so until they are handled.
  class ReadableSockets {
   public:
    ReadableSockets() = default;

   private:
    friend class EventLoop;
    std::array<epoll_event, 8> events_;
    int count_ = 0;
  };
  /// Waits for at most `timeout` (negative: without limit).
  ReadableSockets poll(std::chrono::nanoseconds timeout) const;
  /// Calls the handlers of the readable sockets.
  void handle(const ReadableSockets& readable);
  /// Does both.
  void wait(std::chrono::nanoseconds timeout) { handle(poll(timeout)); }
  /// Ends a `wait`. May be called from any thread.
  void wake() const;

 private:
  EventLoop(FileDescriptor epoll, FileDescriptor wake_up)
      : epoll_(std::move(epoll)), wake_up_(std::move(wake_up)) {}

  FileDescriptor epoll_;
  FileDescriptor wake_up_;
  std::vector<std::function<void()>> handlers_;
  std::chrono::nanoseconds busy_wait_{};
};

}  // namespace ddssec::rtps
