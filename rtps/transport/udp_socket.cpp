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

std::unexpected<Error> failed(Code code, const char* call, const Locator& at) {
  return fail(code, {.document = to_string(at), .field = call, .found = std::strerror(errno)});
}

template <class T>
bool set_option(int fd, int level, int option, const T& value) {
  return setsockopt(fd, level, option, &value, sizeof value) == 0;
}

bool join_group(int fd, const Locator& group, const Locator& interface) {
  if (group.kind == LocatorKind::udp_v4) {
    ip_mreq request{};
    std::memcpy(&request.imr_multiaddr, group.address.data() + 12, 4);
    std::memcpy(&request.imr_interface, interface.address.data() + 12, 4);
    return set_option(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, request);
  }
  ipv6_mreq request{};
  std::memcpy(&request.ipv6mr_multiaddr, group.address.data(), 16);
  return set_option(fd, IPPROTO_IPV6, IPV6_JOIN_GROUP, request);
}

}  // namespace

FileDescriptor::~FileDescriptor() {
  if (fd_ >= 0) ::close(fd_);
}

struct UdpSocket::Batch {
  std::array<std::array<std::uint8_t, kLargestDatagram + 1>, kBatch> octets;
  std::array<sockaddr_storage, kBatch> sources;
  std::array<iovec, kBatch> vectors;
  std::array<mmsghdr, kBatch> headers;
};

void UdpSocket::BatchDelete::operator()(Batch* batch) const noexcept { delete batch; }

UdpSocket::UdpSocket(FileDescriptor fd, const Locator& local)
    : fd_(std::move(fd)), local_(local), batch_(new Batch) {}

Result<UdpSocket> UdpSocket::open(const Locator& at, bool shared) {
  constexpr int kWantedBuffer = 4 << 20;
  const int family = at.kind == LocatorKind::udp_v6 ? AF_INET6 : AF_INET;
  FileDescriptor fd(::socket(family, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (fd.value() < 0) return failed(Code::rtps_socket_failed, "socket", at);
  if (shared) set_option(fd.value(), SOL_SOCKET, SO_REUSEADDR, 1);
  if (family == AF_INET6) set_option(fd.value(), IPPROTO_IPV6, IPV6_V6ONLY, 1);
  set_option(fd.value(), SOL_SOCKET, SO_RCVBUF, kWantedBuffer);
  set_option(fd.value(), SOL_SOCKET, SO_SNDBUF, kWantedBuffer);
  auto address = address_of(at);
  if (::bind(fd.value(), address.raw(), address.size) != 0)
    return failed(errno == EADDRINUSE ? Code::rtps_port_taken : Code::rtps_socket_failed, "bind",
                  at);
  if (::getsockname(fd.value(), address.raw(), &address.size) != 0)
    return failed(Code::rtps_socket_failed, "getsockname", at);
  return UdpSocket(std::move(fd), locator_of(address.storage));
}

Result<UdpSocket> UdpSocket::bind(const Locator& at) { return open(at, false); }

Result<UdpSocket> UdpSocket::on_interface(const Locator& interface) {
  if (interface.is_loopback() || interface.is_unspecified()) return bind(interface);
  auto socket = DDSSEC_TRY(bind({interface.kind, interface.port, {}}));
  socket.local_.address = interface.address;
  // What goes to a group leaves by this interface, whatever the routes say.
  if (interface.kind == LocatorKind::udp_v4) {
    in_addr address{};
    std::memcpy(&address, interface.address.data() + 12, 4);
    if (!set_option(socket.fd(), IPPROTO_IP, IP_MULTICAST_IF, address))
      return failed(Code::rtps_socket_failed, "choose the interface", interface);
  }
  return socket;
}

Result<UdpSocket> UdpSocket::join(const Locator& group, const Locator& interface) {
  auto socket = DDSSEC_TRY(open(group, true));
  if (!join_group(socket.fd(), group, interface))
    return failed(Code::rtps_socket_failed, "join multicast group", group);
  return socket;
}

std::size_t UdpSocket::receive_buffer_size() const {
  int size = 0;
  socklen_t length = sizeof size;
  ::getsockopt(fd(), SOL_SOCKET, SO_RCVBUF, &size, &length);
  return static_cast<std::size_t>(size) / 2;  // Linux counts its book-keeping in: socket(7)
}

std::size_t UdpSocket::fetch() {
  auto& batch = *batch_;
  for (std::size_t i = 0; i < kBatch; ++i) {
    batch.vectors[i] = {batch.octets[i].data(), batch.octets[i].size()};
    batch.headers[i] = {};
    batch.headers[i].msg_hdr.msg_name = &batch.sources[i];
    batch.headers[i].msg_hdr.msg_namelen = sizeof batch.sources[i];
    batch.headers[i].msg_hdr.msg_iov = &batch.vectors[i];
    batch.headers[i].msg_hdr.msg_iovlen = 1;
  }
  const int count = ::recvmmsg(fd(), batch.headers.data(), kBatch, MSG_DONTWAIT, nullptr);
  return count > 0 ? static_cast<std::size_t>(count) : 0;
}

BytesView UdpSocket::datagram(std::size_t index) const {
  const auto size = std::min<std::size_t>(batch_->headers[index].msg_len, kLargestDatagram);
  return BytesView(batch_->octets[index]).first(size);
}

Locator UdpSocket::source(std::size_t index) const { return locator_of(batch_->sources[index]); }

void UdpSocket::send(BytesView message, std::span<const Locator> to) const {
  for (; to.size() > kBatch; to = to.subspan(kBatch)) send_batch(message, to.first(kBatch));
  send_batch(message, to);
}

void UdpSocket::send_batch(BytesView message, std::span<const Locator> to) const {
  std::array<Address, kBatch> addresses;
  std::array<mmsghdr, kBatch> headers{};
  iovec vector{const_cast<std::uint8_t*>(message.data()), message.size()};
  unsigned count = 0;
  for (const auto& locator : to) {
    if (locator.kind != local_.kind) continue;
    addresses[count] = address_of(locator);
    auto& header = headers[count].msg_hdr;
    header.msg_name = addresses[count].raw();
    header.msg_namelen = addresses[count].size;
    header.msg_iov = &vector;
    header.msg_iovlen = 1;
    ++count;
  }
  for (unsigned sent = 0; sent < count;) {
    const int done = ::sendmmsg(fd(), headers.data() + sent, count - sent, 0);
    // A refused address must not keep the others from their message.
    sent += done > 0 ? static_cast<unsigned>(done) : 1;
  }
}

}  // namespace ddssec::rtps
