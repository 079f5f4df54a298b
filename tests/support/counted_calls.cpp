#include "tests/support/counted_calls.hpp"

#include <atomic>
#include <dlfcn.h>
#include <filesystem>
#include <fstream>
#include <pthread.h>
#include <string>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/timerfd.h>
#include <unistd.h>

namespace {

using Count = std::atomic<std::int64_t>;
constinit Count waits, receives, sends, timers, others, locks;

using Lock = int (*)(pthread_mutex_t*);
constinit std::atomic<Lock> real_lock;

void count(Count& one) { one.fetch_add(1, std::memory_order_relaxed); }

}  // namespace

// These take the place of the C library's functions, also for its static libraries.
extern "C" {

int epoll_pwait2(int epoll, epoll_event* events, int most, const timespec* timeout,
                 const sigset_t* mask) {
  count(waits);
  return static_cast<int>(::syscall(SYS_epoll_pwait2, epoll, events, most, timeout, mask, 8));
}

int recvmmsg(int fd, mmsghdr* messages, unsigned count_of, int flags, timespec* timeout) {
  count(receives);
  return static_cast<int>(::syscall(SYS_recvmmsg, fd, messages, count_of, flags, timeout));
}

int sendmmsg(int fd, mmsghdr* messages, unsigned count_of, int flags) {
  count(sends);
  return static_cast<int>(::syscall(SYS_sendmmsg, fd, messages, count_of, flags));
}

int timerfd_settime(int fd, int flags, const itimerspec* when, itimerspec* before) noexcept {
  count(timers);
  return static_cast<int>(::syscall(SYS_timerfd_settime, fd, flags, when, before));
}

ssize_t read(int fd, void* to, size_t size) {
  count(others);
  return ::syscall(SYS_read, fd, to, size);
}

ssize_t write(int fd, const void* from, size_t size) {
  count(others);
  return ::syscall(SYS_write, fd, from, size);
}

int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept {
  count(locks);
  auto lock = real_lock.load(std::memory_order_relaxed);
  if (lock == nullptr) {
    lock = reinterpret_cast<Lock>(::dlsym(RTLD_NEXT, "pthread_mutex_lock"));
    real_lock = lock;
  }
  return lock(mutex);
}

}  // extern "C"

namespace ddssec::counted_calls {

Calls so_far() { return {waits, receives, sends, timers, others, locks}; }

std::int64_t sleeps_of_other_threads() {
  constexpr std::string_view kLine = "voluntary_ctxt_switches:";
  const auto own = std::to_string(::syscall(SYS_gettid));
  std::int64_t sum = 0;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    if (task.path().filename() == own) continue;
    std::ifstream status(task.path() / "status");
    for (std::string line; std::getline(status, line);)
      if (line.starts_with(kLine)) sum += std::stoll(line.substr(kLine.size()));
  }
  return sum;
}

}  // namespace ddssec::counted_calls
