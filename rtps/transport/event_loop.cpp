#include "rtps/transport/event_loop.hpp"

#include <cerrno>
#include <span>
#include <sys/eventfd.h>
#include <unistd.h>

#include "base/errno_text.hpp"

namespace ddssec::rtps {
namespace {

constexpr std::uint64_t kWakeUp = ~0ull;

std::unexpected<Error> call_error(const char* call) {
  return fail(Code::rtps_socket_failed, {.field = call, .found = errno_text(errno)});
}

bool add(int epoll, int fd, std::uint64_t tag) {
  epoll_event event{};
  event.events = EPOLLIN;
  event.data.u64 = tag;
  return ::epoll_ctl(epoll, EPOLL_CTL_ADD, fd, &event) == 0;
}

// Waits for events. Kernels before 5.11 support only whole milliseconds.
int wait_for_events(int epoll, std::span<epoll_event> events, std::chrono::nanoseconds timeout) {
  const bool for_ever = timeout < std::chrono::nanoseconds::zero();
  timeout = std::min(timeout, std::chrono::nanoseconds(std::chrono::hours(1)));
  const auto seconds = std::chrono::floor<std::chrono::seconds>(timeout);
  const timespec time{seconds.count(), (timeout - seconds).count()};
  const auto most = static_cast<int>(events.size());
  const int count = ::epoll_pwait2(epoll, events.data(), most, for_ever ? nullptr : &time, nullptr);
  if (count >= 0 || errno != ENOSYS) return count;
  const auto rounded = std::chrono::ceil<std::chrono::milliseconds>(timeout).count();
  return ::epoll_wait(epoll, events.data(), most, for_ever ? -1 : static_cast<int>(rounded));
}

int look_for_events(int epoll, std::span<epoll_event> events, std::chrono::nanoseconds how_long) {
  const auto end = std::chrono::steady_clock::now() + how_long;
  int count = 0;
  do count = wait_for_events(epoll, events, std::chrono::nanoseconds::zero());
  while (count == 0 && std::chrono::steady_clock::now() < end);
  return count;
}

}  // namespace

Result<EventLoop> EventLoop::create() {
  FileDescriptor epoll(::epoll_create1(EPOLL_CLOEXEC));
  if (epoll.number() < 0) return call_error("epoll_create1");
  FileDescriptor wake_up(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (wake_up.number() < 0 || !add(epoll.number(), wake_up.number(), kWakeUp))
    return call_error("eventfd");
  return EventLoop(std::move(epoll), std::move(wake_up));
}

Status EventLoop::watch(int fd, std::function<void()> on_readable) {
  if (!add(epoll_.number(), fd, handlers_.size())) return call_error("epoll_ctl");
  handlers_.push_back(std::move(on_readable));
  return {};
}

EventLoop::ReadableSockets EventLoop::poll(std::chrono::nanoseconds timeout) const {
  ReadableSockets readable;
  const bool for_ever = timeout < std::chrono::nanoseconds::zero();
  const auto busy = for_ever ? busy_wait_ : std::min(busy_wait_, timeout);
  auto& count = readable.count_;
  if (busy > std::chrono::nanoseconds::zero()) {
    count = look_for_events(epoll_.number(), readable.events_, busy);
    if (!for_ever) timeout -= busy;
  }
  if (count == 0) count = wait_for_events(epoll_.number(), readable.events_, timeout);
  return readable;
}

void EventLoop::handle(const ReadableSockets& readable) {
  for (int i = 0; i < readable.count_; ++i) {
    const auto tag = readable.events_[static_cast<std::size_t>(i)].data.u64;
    if (tag != kWakeUp) {
      handlers_[tag]();
      continue;
    }
    std::uint64_t drained = 0;
    [[maybe_unused]] const auto size = ::read(wake_up_.number(), &drained, sizeof drained);
  }
}

void EventLoop::wake() const {
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto size = ::write(wake_up_.number(), &one, sizeof one);
}

}  // namespace ddssec::rtps
