#include "rtps/transport/udp_socket.hpp"

#include <algorithm>
#include <arpa/inet.h>
#include <array>
#include <cerrno>
#include <cstring>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <fmt/format.h>

#include "base/errno_text.hpp"

namespace ddssec::rtps {
namespace {

struct Address {
  sockaddr_storage storage{};
  socklen_t size = 0;
  sockaddr* raw() { return reinterpret_cast<sockaddr*>(&storage); }
};

Address address_of(const Locator& locator) {
  Address out;
  if (locator.kind == LocatorKind::udp_v4) {
    auto& v4 = reinterpret_cast<sockaddr_in&>(out.storage);
    v4.sin_family = AF_INET;
    v4.sin_port = htons(static_cast<std::uint16_t>(locator.port));
    std::memcpy(&v4.sin_addr, locator.address.data() + 12, 4);
    out.size = sizeof v4;
  } else {
    auto& v6 = reinterpret_cast<sockaddr_in6&>(out.storage);
    v6.sin6_family = AF_INET6;
    v6.sin6_port = htons(static_cast<std::uint16_t>(locator.port));
    std::memcpy(&v6.sin6_addr, locator.address.data(), 16);
    out.size = sizeof v6;
  }
  return out;
}

Locator locator_of(const sockaddr_storage& storage) {
  Locator out;
  if (storage.ss_family == AF_INET) {
    const auto& v4 = reinterpret_cast<const sockaddr_in&>(storage);
    out = {LocatorKind::udp_v4, ntohs(v4.sin_port), {}};
    std::memcpy(out.address.data() + 12, &v4.sin_addr, 4);
  } else if (storage.ss_family == AF_INET6) {
    const auto& v6 = reinterpret_cast<const sockaddr_in6&>(storage);
    out = {LocatorKind::udp_v6, ntohs(v6.sin6_port), {}};
    std::memcpy(out.address.data(), &v6.sin6_addr, 16);
  }
  return out;
}

std::unexpected<Error> socket_error(Code code, const char* call, const Locator& at) {
  return fail(code, {.document = to_string(at), .field = call, .found = errno_text(errno)});
}

Code code_of_errno() {
  switch (errno) {
    case EADDRINUSE:
      return Code::rtps_port_taken;
    case EADDRNOTAVAIL:
      return Code::rtps_address_not_here;
    default:
      return Code::rtps_socket_failed;
  }
}

template <class T>
bool set_option(int fd, int level, int option, const T& value) {
  return setsockopt(fd, level, option, &value, sizeof value) == 0;
}

// Joins the group, or leaves it if `join` is false.
bool change_group(int fd, const Locator& group, const Locator& interface, bool join) {
  if (group.kind != interface.kind) {
    errno = EADDRNOTAVAIL;
    return false;
  }
  if (group.kind == LocatorKind::udp_v4) {
    ip_mreq request{};
    std::memcpy(&request.imr_multiaddr, group.address.data() + 12, 4);
    std::memcpy(&request.imr_interface, interface.address.data() + 12, 4);
    return set_option(fd, IPPROTO_IP, join ? IP_ADD_MEMBERSHIP : IP_DROP_MEMBERSHIP, request);
  }
  ipv6_mreq request{};
  std::memcpy(&request.ipv6mr_multiaddr, group.address.data(), 16);
  return set_option(fd, IPPROTO_IPV6, join ? IPV6_JOIN_GROUP : IPV6_LEAVE_GROUP, request);
}

}  // namespace

struct UdpSocket::Batch {
  std::array<std::array<std::uint8_t, kMaxDatagram + 1>, kBatch> octets;
  std::array<sockaddr_storage, kBatch> sources;
  std::array<iovec, kBatch> vectors;
  std::array<mmsghdr, kBatch> headers;
  std::size_t used = kBatch;  // this many headers must be prepared before the next call

  void prepare(std::size_t i) {
    vectors[i] = {octets[i].data(), octets[i].size()};
    headers[i] = {};
    headers[i].msg_hdr.msg_name = &sources[i];
    headers[i].msg_hdr.msg_namelen = sizeof sources[i];
    headers[i].msg_hdr.msg_iov = &vectors[i];
    headers[i].msg_hdr.msg_iovlen = 1;
  }
};

void UdpSocket::BatchDelete::operator()(Batch* batch) const noexcept { delete batch; }

UdpSocket::UdpSocket(FileDescriptor fd, const Locator& local) : fd_(std::move(fd)), local_(local) {}

void UdpSocket::keep_no_input() const { set_option(fd(), SOL_SOCKET, SO_RCVBUF, 1); }

Result<UdpSocket> UdpSocket::open(const Locator& at, bool shared, std::size_t buffer) {
  const auto octets = static_cast<int>(buffer);
  const int family = at.kind == LocatorKind::udp_v6 ? AF_INET6 : AF_INET;
  FileDescriptor fd(::socket(family, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (fd.number() < 0) return socket_error(Code::rtps_socket_failed, "socket", at);
  if (shared) set_option(fd.number(), SOL_SOCKET, SO_REUSEADDR, 1);
  if (family == AF_INET6) set_option(fd.number(), IPPROTO_IPV6, IPV6_V6ONLY, 1);
  set_option(fd.number(), SOL_SOCKET, SO_RCVBUF, octets);
  set_option(fd.number(), SOL_SOCKET, SO_SNDBUF, octets);
  auto address = address_of(at);
  if (::bind(fd.number(), address.raw(), address.size) != 0)
    return socket_error(code_of_errno(), "bind", at);
  if (::getsockname(fd.number(), address.raw(), &address.size) != 0)
    return socket_error(Code::rtps_socket_failed, "getsockname", at);
  return UdpSocket(std::move(fd), locator_of(address.storage));
}

Result<UdpSocket> UdpSocket::bind(const Locator& at, std::size_t buffer) {
  return open(at, false, buffer);
}

Result<UdpSocket> UdpSocket::on_interface(const Locator& interface, std::size_t buffer) {
  if (interface.is_loopback() || interface.is_unspecified()) return bind(interface, buffer);
  return everywhere(interface, buffer);
}

Result<UdpSocket> UdpSocket::everywhere(const Locator& interface, std::size_t buffer) {
  DDSSEC_ASSIGN_OR_RETURN(auto socket, bind({interface.kind, interface.port, {}}, buffer));
  DDSSEC_RETURN_IF_ERROR(socket.use(interface));
  return socket;
}

Status UdpSocket::use(const Locator& interface) {
  // Messages to a group are sent through this interface, whatever the routing table says.
  if (interface.kind == LocatorKind::udp_v4) {
    in_addr address{};
    std::memcpy(&address, interface.address.data() + 12, 4);
    if (!set_option(fd(), IPPROTO_IP, IP_MULTICAST_IF, address))
      return socket_error(code_of_errno(), "choose the interface", interface);
  }
  local_.address = interface.address;
  return {};
}

Result<UdpSocket> UdpSocket::join(const Locator& group, const Locator& interface) {
  DDSSEC_ASSIGN_OR_RETURN(auto socket, open(group, true, kWantedBuffer));
  DDSSEC_RETURN_IF_ERROR(socket.join_also(group, interface));
  return socket;
}

Status UdpSocket::join_also(const Locator& group, const Locator& interface) {
  if (change_group(fd(), group, interface, true)) return {};
  return socket_error(Code::rtps_no_multicast, "join multicast group", group);
}

void UdpSocket::leave(const Locator& group, const Locator& interface) const {
  change_group(fd(), group, interface, false);
}

std::size_t UdpSocket::receive_buffer_size() const {
  int size = 0;
  socklen_t length = sizeof size;
  ::getsockopt(fd(), SOL_SOCKET, SO_RCVBUF, &size, &length);
  // Linux includes its own overhead, which takes half: socket(7).
  return static_cast<std::size_t>(size) / 2;
}

Status UdpSocket::check_receive_buffer() const {
  const auto granted = receive_buffer_size();
  if (granted >= kNeededBuffer) return {};
  return fail(Code::rtps_receive_buffer_small, {.document = to_string(local_),
                                                .field = "SO_RCVBUF",
                                                .expected = fmt::format("{} octets", kNeededBuffer),
                                                .found = fmt::format("{} octets", granted)});
}

std::size_t UdpSocket::fetch() {
  if (batch_ == nullptr) batch_.reset(new Batch);
  auto& batch = *batch_;
  // The kernel changed the headers that it filled last time, so they are prepared again.
  for (; batch.used > 0; --batch.used) batch.prepare(batch.used - 1);
  const int count = ::recvmmsg(fd(), batch.headers.data(), kBatch, MSG_DONTWAIT, nullptr);
  batch.used = count > 0 ? static_cast<std::size_t>(count) : 0;
  return batch.used;
}

BytesView UdpSocket::datagram(std::size_t index) const {
  const auto size = std::min<std::size_t>(batch_->headers[index].msg_len, kMaxDatagram);
  return BytesView(batch_->octets[index]).first(size);
}

Locator UdpSocket::source(std::size_t index) const { return locator_of(batch_->sources[index]); }

// The datagrams of one sendmmsg call.
class UdpSocket::SendCall {
 public:
  SendCall(const UdpSocket& socket, std::uint8_t dscp, const Unsent& unsent)
      : fd_(socket.fd()), has_class_(dscp != 0), unsent_(unsent) {
    if (!has_class_) return;
    const bool v6 = socket.local_.kind == LocatorKind::udp_v6;
    msghdr message{};
    message.msg_control = control_.data();
    message.msg_controllen = control_.size();
    auto& header = *CMSG_FIRSTHDR(&message);
    header.cmsg_level = v6 ? IPPROTO_IPV6 : IPPROTO_IP;
    header.cmsg_type = v6 ? IPV6_TCLASS : IP_TOS;
    header.cmsg_len = CMSG_LEN(sizeof(int));
    // The lower two bits are for congestion notification (RFC 3168).
    const int traffic_class = dscp << 2;
    std::memcpy(CMSG_DATA(&header), &traffic_class, sizeof traffic_class);
  }
  void add(BytesView message, const Locator& to) {
    if (count_ == kBatch) flush();
    locators_[count_] = &to;
    addresses_[count_] = address_of(to);
    vectors_[count_] = {const_cast<std::uint8_t*>(message.data()), message.size()};
    auto& header = headers_[count_].msg_hdr;
    header = {};
    header.msg_name = addresses_[count_].raw();
    header.msg_namelen = addresses_[count_].size;
    header.msg_iov = &vectors_[count_];
    header.msg_iovlen = 1;
    if (has_class_) {
      header.msg_control = control_.data();
      header.msg_controllen = control_.size();
    }
    ++count_;
  }
  void flush() {
    for (unsigned sent = 0; sent < count_;) {
      const int done = ::sendmmsg(fd_, headers_.data() + sent, count_ - sent, 0);
      const bool is_full = done < 0 && (errno == EAGAIN || errno == EWOULDBLOCK);
      if (is_full && unsent_) unsent_(message(sent), *locators_[sent]);
      // One refused address must not prevent sending to the others.
      sent += done > 0 ? static_cast<unsigned>(done) : 1;
    }
    count_ = 0;
  }

 private:
  BytesView message(unsigned index) const {
    return {static_cast<const std::uint8_t*>(vectors_[index].iov_base), vectors_[index].iov_len};
  }

  const int fd_;
  const bool has_class_;
  const Unsent& unsent_;
  alignas(cmsghdr) std::array<std::uint8_t, CMSG_SPACE(sizeof(int))> control_{};
  unsigned count_ = 0;
  std::array<const Locator*, kBatch> locators_;
  std::array<Address, kBatch> addresses_;
  std::array<iovec, kBatch> vectors_;
  std::array<mmsghdr, kBatch> headers_;
};

void UdpSocket::send_all(const OutgoingMessages& out, const Unsent& unsent) const {
  SendCall sending(*this, out.dscp, unsent);
  for (const auto& message : out.messages)
    for (const auto& locator : out.to)
      if (locator.kind == local_.kind) sending.add(message, locator);
  sending.flush();
}

}  // namespace ddssec::rtps
