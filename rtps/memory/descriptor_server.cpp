#include "rtps/memory/descriptor_server.hpp"

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <fcntl.h>
#include <string>
#include <string_view>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>

#include "base/bytes.hpp"

namespace ddssec::rtps::memory {
namespace {

constexpr std::size_t kTokenSize = 32;
constexpr int kAcceptsOfATurn = 32;
constexpr int kBacklog = 128;
constexpr std::chrono::seconds kPause{1};
// How long accepting pauses if too many closes wait. Most closes are quick, and strangers that send
// descriptors must not keep readers waiting for long.
constexpr std::chrono::milliseconds kPauseForCloses{50};
constexpr std::string_view kPrefix = "ddssec-";

struct Address {
  sockaddr_un octets{};
  socklen_t size = 0;
  const sockaddr* generic() const {
    return static_cast<const sockaddr*>(static_cast<const void*>(&octets));
  }
};

// The address is abstract: it leaves no file behind, even after kill -9. The address is not a
// secret, but the token is.
Address address_of(const SocketName& name) {
  Address out;
  out.octets.sun_family = AF_UNIX;
  const std::string text = std::string(kPrefix) + to_hex(name);
  static_assert(kPrefix.size() + 2 * sizeof(SocketName) < sizeof out.octets.sun_path - 1);
  std::memcpy(out.octets.sun_path + 1, text.data(), text.size());
  out.size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + text.size());
  return out;
}

FileDescriptor local_socket() {
  // The socket has packets, so that a token arrives whole or not at all.
  return FileDescriptor(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
}

bool would_block(int error) { return error == EAGAIN || error == EWOULDBLOCK || error == EINTR; }

MemoryResult<Token> new_token(Random& random) {
  auto out = Token::fill(kTokenSize, [&](MutableBytes octets) { return random.fill(octets); });
  if (!out) return refuse(MemoryRefusal::no_socket);
  return *std::move(out);
}

union Control {
  cmsghdr head;
  std::array<char, CMSG_SPACE(sizeof(int))> octets;
};

void send_descriptor(int socket, int descriptor) {
  std::uint8_t octet = 1;
  iovec part{.iov_base = &octet, .iov_len = 1};
  Control control{};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.octets.data();
  message.msg_controllen = control.octets.size();
  cmsghdr* const head = CMSG_FIRSTHDR(&message);
  head->cmsg_level = SOL_SOCKET;
  head->cmsg_type = SCM_RIGHTS;
  head->cmsg_len = CMSG_LEN(sizeof(int));
  std::memcpy(CMSG_DATA(head), &descriptor, sizeof descriptor);
  // A reader that is gone by now needs no descriptor, so an error is ignored.
  static_cast<void>(::sendmsg(socket, &message, MSG_NOSIGNAL | MSG_DONTWAIT));
}

// Room for several descriptors, although one is expected. The kernel closes those that have no
// room, which may hold this thread up. But still more room would let a peer use up the descriptors
// of the process.
struct ManyDescriptors {
  static constexpr std::size_t kMax = 16;
  static constexpr std::size_t kTime = CMSG_SPACE(sizeof(timeval));  // see UntrustedSocket
  alignas(cmsghdr) std::array<char, CMSG_SPACE(kMax * sizeof(int)) + kTime> octets{};
};

std::vector<FileDescriptor> received_with(msghdr& message) {
  std::vector<FileDescriptor> out;
  for (auto* head = CMSG_FIRSTHDR(&message); head != nullptr; head = CMSG_NXTHDR(&message, head)) {
    if (head->cmsg_level != SOL_SOCKET || head->cmsg_type != SCM_RIGHTS) continue;
    for (std::size_t at = CMSG_LEN(0); at + sizeof(int) <= head->cmsg_len; at += sizeof(int)) {
      int number = -1;
      std::memcpy(&number, static_cast<const char*>(static_cast<const void*>(head)) + at,
                  sizeof number);
      out.emplace_back(number);
    }
  }
  return out;
}

std::optional<ucred> other_side(int socket) {
  ucred who{};
  socklen_t size = sizeof who;
  if (::getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &who, &size) != 0) return std::nullopt;
  return who;
}

bool admits(Users users, uid_t user) {
  return users == Users::any || user == 0 || user == ::geteuid();
}

}  // namespace

MemoryResult<DescriptorServer> DescriptorServer::listen(Random& random, Users users) {
  DescriptorServer out;
  if (!random.fill(out.name_)) return refuse(MemoryRefusal::no_socket);
  out.users_ = users;
  out.listener_ = local_socket();
  const Address address = address_of(out.name_);
  if (!out.listener_ || ::bind(out.listener_.number(), address.generic(), address.size) != 0 ||
      ::listen(out.listener_.number(), kBacklog) != 0)
    return refuse(MemoryRefusal::no_socket);
  out.connections_.reserve(kMaxConnections + 1);
  return out;
}

DescriptorServer& DescriptorServer::operator=(DescriptorServer&& other) noexcept {
  std::swap(name_, other.name_);
  std::swap(users_, other.users_);
  std::swap(listener_, other.listener_);
  std::swap(offers_, other.offers_);
  std::swap(connections_, other.connections_);
  std::swap(paused_until_, other.paused_until_);
  return *this;
}

// Closing the listener would drop what waiting connections have already sent, and that can hold up
// this thread. So they are accepted and closed elsewhere.
DescriptorServer::~DescriptorServer() {
  if (!listener_) return;
  ::shutdown(listener_.number(), SHUT_RDWR);
  for (int i = 0; i <= kBacklog; ++i)
    if (!UntrustedSocket(
            FileDescriptor(::accept4(listener_.number(), nullptr, nullptr, SOCK_CLOEXEC))))
      return;
}

MemoryResult<DescriptorOffer> DescriptorServer::offer(const Segment& segment, Random& random,
                                                      MonotonicTime now, std::string identity) {
  offers_->forget_late(now);
  auto descriptor = segment.for_reader();
  if (!descriptor) return refuse(MemoryRefusal::no_memory);
  auto token = new_token(random);
  if (!token) return refuse(token.error());
  const auto added = offers_->add({.token = token->clone(),
                                   .descriptor = std::move(descriptor),
                                   .segment = segment.id(),
                                   .until = now + OpenOffers::kLifetime,
                                   .identity = std::move(identity)});
  if (!added) return refuse(added.error());
  return DescriptorOffer{.name = name_,
                         .token = *std::move(token),
                         .process = ::getpid(),
                         .segment = segment.id(),
                         .memory = segment.memory()};
}

void DescriptorServer::watch(std::vector<pollfd>& out) const {
  if (!paused_until_) out.push_back({.fd = listener_.number(), .events = POLLIN, .revents = 0});
  for (const auto& connection : connections_)
    out.push_back({.fd = connection.socket.number(), .events = POLLIN, .revents = 0});
}

std::optional<MonotonicTime> DescriptorServer::deadline() const {
  auto out = paused_until_;
  for (const auto& each : connections_) out = out ? std::min(*out, each.until) : each.until;
  return out;
}

void DescriptorServer::serve(MonotonicTime now) {
  forget_late(now);
  if (!paused_until_) accept_waiting(now);
  std::erase_if(connections_, [&](const Connection& each) { return is_done(each); });
}

void DescriptorServer::forget_late(MonotonicTime now) {
  std::erase_if(connections_, [&](const Connection& each) { return each.until <= now; });
  if (paused_until_ && *paused_until_ <= now) paused_until_.reset();
}

void DescriptorServer::accept_waiting(MonotonicTime now) {
  for (int i = 0; i < kAcceptsOfATurn; ++i) {
    if (closes_too_many()) {
      paused_until_ = now + kPauseForCloses;
      return;
    }
    UntrustedSocket socket(FileDescriptor(
        ::accept4(listener_.number(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK)));
    if (!socket) {
      if (would_block(errno) || errno == ECONNABORTED) return;
      // No descriptors are left, and the waiting connection would wake the caller again and again.
      paused_until_ = now + kPause;
      return;
    }
    const auto who = other_side(socket.number());
    if (!who || !admits(users_, who->uid)) continue;
    Connection connection{std::move(socket), who->pid, who->uid, now + kSilence};
    // A reader sends its token at once, so connections that send nothing do not keep it waiting.
    if (!is_done(connection)) keep(std::move(connection));
  }
}

// Keeps the connection. If there are too many, the oldest one is closed: of the process, of the
// user, or of all.
void DescriptorServer::keep(Connection connection) {
  const auto leave_at = [&](std::size_t limit, auto&& counts) {
    if (std::ranges::count_if(connections_, counts) < static_cast<std::ptrdiff_t>(limit)) return;
    const auto oldest = std::ranges::find_if(connections_, counts);
    connections_.erase(oldest);
  };
  leave_at(kMaxOfOne, [&](const auto& other) { return other.process == connection.process; });
  if (connection.user != ::geteuid())
    leave_at(kMaxOfOne, [&](const auto& other) { return other.user == connection.user; });
  leave_at(kMaxConnections, [](const auto&) { return true; });
  connections_.push_back(std::move(connection));
}

// True if the connection has shown its token, or never will.
bool DescriptorServer::is_done(const Connection& connection) {
  std::array<std::uint8_t, kTokenSize + 1> octets{};
  const int socket = connection.socket.number();
  const auto next = connection.socket.next();
  if (next == UntrustedSocket::Next::nothing) return false;
  // The socket is closed elsewhere, with the descriptors.
  if (next == UntrustedSocket::Next::descriptors) return true;
  const auto size = ::recv(socket, octets.data(), octets.size(), MSG_DONTWAIT);
  if (size < 0 && would_block(errno)) return false;
  if (size != static_cast<ssize_t>(kTokenSize)) return true;
  auto token = Token::copy_of(BytesView(octets).first(kTokenSize));
  wipe(octets);
  if (!token) return true;
  if (const auto descriptor = offers_->redeem(*token)) send_descriptor(socket, descriptor.number());
  return true;
}

MemoryResult<DescriptorRequest> DescriptorRequest::send(const DescriptorOffer& offer, Users users) {
  if (closes_too_many()) return refuse(MemoryRefusal::held_up);
  DescriptorRequest out;
  out.socket_ = UntrustedSocket(local_socket());
  const Address address = address_of(offer.name);
  const int socket = out.descriptor();
  if (socket < 0 || ::connect(socket, address.generic(), address.size) != 0)
    return refuse(MemoryRefusal::no_socket);
  const auto who = other_side(socket);
  if (!who || who->pid != offer.process || who->pid <= 0)
    return refuse(MemoryRefusal::wrong_process);
  if (!admits(users, who->uid)) return refuse(MemoryRefusal::other_user);
  const bool is_sent = offer.token.expose([&](BytesView token) {
    return ::send(socket, token.data(), token.size(), MSG_NOSIGNAL | MSG_DONTWAIT) ==
           static_cast<ssize_t>(token.size());
  });
  if (!is_sent) return refuse(MemoryRefusal::no_socket);
  out.segment_ = offer.segment;
  out.memory_ = offer.memory;
  return out;
}

MemoryResult<std::optional<MappedSegment>> DescriptorRequest::take() {
  if (closes_too_many()) return refuse(MemoryRefusal::held_up);
  std::uint8_t octet = 0;
  iovec part{.iov_base = &octet, .iov_len = 1};
  ManyDescriptors control;
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.octets.data();
  message.msg_controllen = control.octets.size();
  const auto size = ::recvmsg(descriptor(), &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
  if (size < 0 && would_block(errno)) return std::optional<MappedSegment>();
  if (size < 0) return refuse(MemoryRefusal::no_answer);
  auto received = received_with(message);
  // Only memory that can be sealed is closed here, because no other process can delay that.
  const auto is_foreign = [](const auto& one) { return ::fcntl(one.number(), F_GET_SEALS) < 0; };
  const bool any_foreign = std::ranges::any_of(received, is_foreign);
  for (auto& one : received)
    if (is_foreign(one)) close_elsewhere(std::move(one));
  if (any_foreign) return refuse(MemoryRefusal::wrong_kind);
  if (received.size() != 1 || size != 1 || (message.msg_flags & (MSG_CTRUNC | MSG_TRUNC)) != 0)
    return refuse(MemoryRefusal::no_answer);
  auto segment = MappedSegment::map(received[0], segment_, memory_);
  if (!segment) return refuse(segment.error());
  return std::optional<MappedSegment>(*std::move(segment));
}

}  // namespace ddssec::rtps::memory
