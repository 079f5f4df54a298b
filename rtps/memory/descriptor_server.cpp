#include "rtps/memory/descriptor_server.hpp"

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <fcntl.h>
#include <string>
#include <string_view>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/un.h>

#include "base/bytes.hpp"
#include "rtps/memory/outside_descriptor.hpp"

namespace ddssec::rtps::memory {
namespace {

constexpr std::size_t kTokenSize = 32;
constexpr int kAcceptsOfATurn = 32;
constexpr std::chrono::seconds kPause{1};
constexpr std::string_view kPrefix = "ddssec-";

struct Address {
  sockaddr_un octets{};
  socklen_t size = 0;
  const sockaddr* generic() const {
    return static_cast<const sockaddr*>(static_cast<const void*>(&octets));
  }
};

// Abstract: it leaves no file behind, also after kill -9. It is not a secret; the token is.
Address address_of(const SocketName& name) {
  Address out;
  out.octets.sun_family = AF_UNIX;
  const std::string text = std::string(kPrefix) + to_hex(name);
  static_assert(kPrefix.size() + 2 * sizeof(SocketName) < sizeof out.octets.sun_path - 1);
  std::memcpy(out.octets.sun_path + 1, text.data(), text.size());
  out.size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + text.size());
  return out;
}

Descriptor local_socket() {
  // Packets: a token arrives whole or not at all.
  return Descriptor(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
}

bool would_block(int error) { return error == EAGAIN || error == EWOULDBLOCK || error == EINTR; }

bool watch(const Descriptor& poll, int descriptor) {
  epoll_event event{};
  event.events = EPOLLIN;
  return ::epoll_ctl(poll.number(), EPOLL_CTL_ADD, descriptor, &event) == 0;
}

Outcome<Token> new_token(Random& random) {
  auto out = Token::fill(kTokenSize, [&](MutableBytes octets) { return random.fill(octets); });
  if (!out) return refuse(Refusal::no_socket);
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
  // A reader that is gone by now needs no descriptor.
  static_cast<void>(::sendmsg(socket, &message, MSG_NOSIGNAL | MSG_DONTWAIT));
}

bool is_process(int socket, pid_t process) {
  ucred who{};
  socklen_t size = sizeof who;
  return ::getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &who, &size) == 0 && process > 0 &&
         who.pid == process;
}

}  // namespace

Outcome<DescriptorServer> DescriptorServer::listen(Random& random) {
  DescriptorServer out;
  if (!random.fill(out.name_)) return refuse(Refusal::no_socket);
  out.listener_ = local_socket();
  out.poll_ = Descriptor(::epoll_create1(EPOLL_CLOEXEC));
  const Address address = address_of(out.name_);
  if (!out.listener_ || !out.poll_ ||
      ::bind(out.listener_.number(), address.generic(), address.size) != 0 ||
      ::listen(out.listener_.number(), kMaxConnections) != 0 ||
      !watch(out.poll_, out.listener_.number()))
    return refuse(Refusal::no_socket);
  out.offers_.reserve(kMaxOffers);
  out.connections_.reserve(kMaxConnections);
  return out;
}

Outcome<Offer> DescriptorServer::offer(const Segment& segment, Random& random, MonotonicTime now) {
  forget_late(now);
  if (offers_.size() >= kMaxOffers) return refuse(Refusal::too_many_tokens);
  Descriptor descriptor(::fcntl(segment.descriptor(), F_DUPFD_CLOEXEC, 0));
  if (!descriptor) return refuse(Refusal::no_memory);
  auto token = new_token(random);
  if (!token) return refuse(token.error());
  offers_.push_back({.token = token->clone(),
                     .descriptor = std::move(descriptor),
                     .segment = segment.id(),
                     .until = now + kOfferLifetime});
  return Offer{.name = name_,
               .token = *std::move(token),
               .process = ::getpid(),
               .segment = segment.id(),
               .memory = segment.memory()};
}

void DescriptorServer::withdraw(std::uint64_t segment) {
  std::erase_if(offers_, [&](const Open& open) { return open.segment == segment; });
}

std::optional<MonotonicTime> DescriptorServer::deadline() const {
  auto out = paused_until_;
  const auto consider = [&](MonotonicTime at) { out = out ? std::min(*out, at) : at; };
  for (const auto& open : offers_) consider(open.until);
  for (const auto& connection : connections_) consider(connection.until);
  return out;
}

void DescriptorServer::serve(MonotonicTime now) {
  forget_late(now);
  if (!paused_until_) accept_waiting(now);
  std::erase_if(connections_, [&](const Connection& each) { return is_done(each); });
}

void DescriptorServer::watch_listener(bool on) {
  epoll_event event{};
  event.events = on ? EPOLLIN : 0U;
  ::epoll_ctl(poll_.number(), EPOLL_CTL_MOD, listener_.number(), &event);
}

void DescriptorServer::forget_late(MonotonicTime now) {
  std::erase_if(offers_, [&](const Open& open) { return open.until <= now; });
  std::erase_if(connections_, [&](const Connection& each) { return each.until <= now; });
  if (paused_until_ && *paused_until_ <= now) {
    paused_until_.reset();
    watch_listener(true);
  }
}

void DescriptorServer::accept_waiting(MonotonicTime now) {
  for (int i = 0; i < kAcceptsOfATurn; ++i) {
    Descriptor socket(
        ::accept4(listener_.number(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (!socket) {
      if (would_block(errno) || errno == ECONNABORTED) return;
      // No descriptors are left. The waiting connection would wake the caller again and again.
      paused_until_ = now + kPause;
      watch_listener(false);
      return;
    }
    Connection connection{.socket = std::move(socket), .until = now + kSilence};
    // A reader sends its token at once. It is not kept waiting by those that say nothing.
    if (is_done(connection) || !watch(poll_, connection.socket.number())) continue;
    if (connections_.size() >= kMaxConnections) connections_.erase(connections_.begin());
    connections_.push_back(std::move(connection));
  }
}

/// True if the connection has shown its token, or never will.
bool DescriptorServer::is_done(const Connection& connection) {
  std::array<std::uint8_t, kTokenSize + 1> octets{};
  const int socket = connection.socket.number();
  const auto size = ::recv(socket, octets.data(), octets.size(), MSG_DONTWAIT);
  if (size < 0 && would_block(errno)) return false;
  if (size != static_cast<ssize_t>(kTokenSize)) return true;
  auto token = Token::copy_of(BytesView(octets).first(kTokenSize));
  wipe(octets);
  if (!token) return true;
  if (const auto open = redeem(*token)) send_descriptor(socket, open->descriptor.number());
  return true;
}

/// Takes the offer away, so that its token does not work again. All offers are compared, so that
/// the time says nothing about them.
std::optional<DescriptorServer::Open> DescriptorServer::redeem(const Token& token) {
  std::size_t found = offers_.size();
  for (std::size_t i = 0; i < offers_.size(); ++i)
    if (offers_[i].token == token) found = i;
  if (found == offers_.size()) return std::nullopt;
  auto out = std::move(offers_[found]);
  offers_.erase(offers_.begin() + static_cast<std::ptrdiff_t>(found));
  return out;
}

Outcome<DescriptorRequest> DescriptorRequest::send(const Offer& offer) {
  DescriptorRequest out;
  out.socket_ = local_socket();
  const Address address = address_of(offer.name);
  const int socket = out.descriptor();
  if (socket < 0 || ::connect(socket, address.generic(), address.size) != 0)
    return refuse(Refusal::no_socket);
  if (!is_process(socket, offer.process)) return refuse(Refusal::wrong_process);
  const bool is_sent = offer.token.expose([&](BytesView token) {
    return ::send(socket, token.data(), token.size(), MSG_NOSIGNAL | MSG_DONTWAIT) ==
           static_cast<ssize_t>(token.size());
  });
  if (!is_sent) return refuse(Refusal::no_socket);
  out.segment_ = offer.segment;
  out.memory_ = offer.memory;
  return out;
}

Outcome<std::optional<MappedSegment>> DescriptorRequest::take() {
  if (closes_too_many()) return refuse(Refusal::wrong_kind);
  std::uint8_t octet = 0;
  iovec part{.iov_base = &octet, .iov_len = 1};
  Control control{};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.octets.data();
  message.msg_controllen = CMSG_LEN(sizeof(int));  // one descriptor: the kernel drops others
  const auto size = ::recvmsg(descriptor(), &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
  if (size < 0 && would_block(errno)) return std::optional<MappedSegment>();
  const cmsghdr* const head = size < 0 ? nullptr : CMSG_FIRSTHDR(&message);
  if (head == nullptr || head->cmsg_level != SOL_SOCKET || head->cmsg_type != SCM_RIGHTS ||
      head->cmsg_len != CMSG_LEN(sizeof(int)))
    return refuse(Refusal::no_answer);
  int number = -1;
  std::memcpy(&number, CMSG_DATA(head), sizeof number);
  Descriptor received(number);
  if (::fcntl(number, F_GET_SEALS) < 0) {
    close_elsewhere(std::move(received));
    return refuse(Refusal::wrong_kind);
  }
  if (size != 1 || (message.msg_flags & (MSG_CTRUNC | MSG_TRUNC)) != 0)
    return refuse(Refusal::no_answer);
  auto segment = MappedSegment::map(received, segment_, memory_);
  if (!segment) return refuse(segment.error());
  return std::optional<MappedSegment>(*std::move(segment));
}

}  // namespace ddssec::rtps::memory
