#include "rtps/memory/untrusted_socket.hpp"

#include <array>
#include <cerrno>
#include <mutex>
#include <sys/socket.h>
#include <sys/time.h>
#include <system_error>
#include <thread>
#include <vector>

#include "base/background_thread.hpp"

namespace ddssec::rtps::memory {
namespace {

constexpr std::size_t kMaxWaiting = 512;
constexpr std::size_t kTooMany = 8;

struct Closer {
  Closer() { waiting.reserve(kMaxWaiting); }
  std::mutex lock;
  std::vector<int> waiting;
  bool runs = false;  // true while the thread runs, which may be closing one that no longer waits
};

// The object is never destroyed, because its thread may outlast main.
Closer& closer() {
  static auto* const out = new Closer;
  return *out;
}

void close_all() {
  auto& all = closer();
  std::unique_lock held(all.lock);
  while (!all.waiting.empty()) {
    const int number = all.waiting.back();
    all.waiting.pop_back();
    held.unlock();
    ::close(number);
    held.lock();
  }
  all.runs = false;
}

enum class Front : std::uint8_t { nothing, end, error, octets, descriptors };

// Looks at the next message without removing it or its descriptors. A message comes with its time
// (SO_TIMESTAMP), which fills the room for control data. So the end can be told from an empty
// message, and no descriptor is installed.
Front front_of(int socket) {
  char octet = 0;
  iovec part{.iov_base = &octet, .iov_len = 1};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(timeval))> time{};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = time.data();
  message.msg_controllen = time.size();
  const auto size = ::recvmsg(socket, &message, MSG_PEEK | MSG_DONTWAIT);
  if (size < 0) return errno == EAGAIN || errno == EINTR ? Front::nothing : Front::error;
  if ((message.msg_flags & MSG_CTRUNC) != 0) return Front::descriptors;
  return size == 0 && CMSG_FIRSTHDR(&message) == nullptr ? Front::end : Front::octets;
}

// True if nothing more can arrive. Messages without descriptors are dropped; there are as many as
// the system lets a sender queue, in general 10 to 512. An error comes before them (ECONNRESET),
// and is reported once: nothing may be received before the next look.
bool is_empty(int socket) {
  constexpr int kMax = 1024;
  for (int i = 0; i < kMax; ++i) {
    const auto front = front_of(socket);
    if (front == Front::error) continue;
    if (front == Front::descriptors) return false;
    if (front != Front::octets) return true;
    char octet = 0;
    static_cast<void>(::recv(socket, &octet, 1, MSG_DONTWAIT));
  }
  return false;
}

}  // namespace

void close_elsewhere(FileDescriptor descriptor) {
  auto& all = closer();
  const std::lock_guard held(all.lock);
  const int number = descriptor.release();
  if (number < 0 || all.waiting.size() == kMaxWaiting) return;
  all.waiting.push_back(number);
  if (all.runs) return;
  try {
    start_background_thread<std::thread>(close_all).detach();
    all.runs = true;
  } catch (const std::system_error&) {
    // The descriptor is closed with the next one.
  }
}

bool closes_too_many() {
  auto& all = closer();
  const std::lock_guard held(all.lock);
  return all.waiting.size() + (all.runs ? 1 : 0) >= kTooMany;
}

UntrustedSocket::UntrustedSocket(FileDescriptor socket) : socket_(std::move(socket)) {
  const int on = 1;
  if (socket_) ::setsockopt(number(), SOL_SOCKET, SO_TIMESTAMP, &on, sizeof on);
}

UntrustedSocket::~UntrustedSocket() {
  if (!socket_) return;
  ::shutdown(socket_.number(), SHUT_RDWR);
  if (!is_empty(socket_.number())) close_elsewhere(std::move(socket_));
}

UntrustedSocket::Next UntrustedSocket::next() const {
  auto front = front_of(number());
  for (int i = 0; i < 4 && front == Front::error; ++i) front = front_of(number());
  // There may be descriptors: nothing is received.
  if (front == Front::error) return Next::descriptors;
  if (front == Front::nothing) return Next::nothing;
  return front == Front::descriptors ? Next::descriptors : Next::octets;
}

}  // namespace ddssec::rtps::memory
