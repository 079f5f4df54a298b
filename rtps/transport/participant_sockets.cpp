#include "rtps/transport/participant_sockets.hpp"

#include <algorithm>

namespace ddssec::rtps {
namespace {

// A socket of the loopback alone cannot be reached from other machines.
Result<UdpSocket> socket_at(std::span<const NetworkInterface> interfaces, std::uint32_t port,
                            std::size_t receive_buffer) {
  auto address = interfaces.front().address;
  address.port = port;
  return interfaces.size() == 1 ? UdpSocket::on_interface(address, receive_buffer)
                                : UdpSocket::everywhere(address, receive_buffer);
}

}  // namespace

Result<std::unique_ptr<ParticipantSockets>> ParticipantSockets::open(
    DomainId domain, std::vector<NetworkInterface> interfaces, std::size_t receive_buffer) {
  for (int index = 0; index < ports::kMostIndexes; ++index) {
    auto metatraffic = socket_at(interfaces, ports::metatraffic(domain, index), receive_buffer);
    if (!metatraffic && metatraffic.error().code() == Code::rtps_port_taken) continue;
    if (!metatraffic) return std::unexpected(metatraffic.error());
    auto user = socket_at(interfaces, ports::user(domain, index), receive_buffer);
    if (!user && user.error().code() == Code::rtps_port_taken) continue;
    if (!user) return std::unexpected(user.error());
    DDSSEC_ASSIGN_OR_RETURN(auto event_loop, EventLoop::create());
    auto open_more = [interfaces, receive_buffer] {
      return socket_at(interfaces, 0, receive_buffer);
    };
    std::unique_ptr<ParticipantSockets> out(new ParticipantSockets(
        std::move(event_loop), std::move(interfaces), index, std::move(open_more)));
    out->sockets_.push_back(std::move(*metatraffic));
    out->sockets_.push_back(std::move(*user));
    return out;
  }
  return fail(Code::rtps_port_taken, {.document = to_string(interfaces),
                                      .field = "participant index",
                                      .expected = "a free one below 120",
                                      .found = "all taken"});
}

Status ParticipantSockets::join(const Locator& group, const NetworkInterface& interface) {
  if (has_joined())
    DDSSEC_RETURN_IF_ERROR(sockets_.back().join_also(group, interface.address));
  else {
    DDSSEC_ASSIGN_OR_RETURN(auto udp_socket, UdpSocket::join(group, interface.address));
    sockets_.push_back(std::move(udp_socket));
  }
  if (interface.address.address != interfaces_.front().address.address) {
    DDSSEC_ASSIGN_OR_RETURN(auto udp_socket, UdpSocket::everywhere(interface.address));
    further_.push_back(std::move(udp_socket));
  }
  return {};
}

Status ParticipantSockets::listen(std::function<void(UdpSocket&)> f) {
  receive_ = std::move(f);
  for (auto& socket : sockets_)
    DDSSEC_RETURN_IF_ERROR(loop_.watch(socket.fd(), [this, &socket] { receive_(socket); }));
  return {};
}

void ParticipantSockets::send(BytesView message, std::span<const Locator> to) {
  send_all({{&message, 1}, to});
}

void ParticipantSockets::send_all(const Outgoing& out) {
  if (interfaces_.size() == 1 || std::ranges::none_of(out.to, &Locator::is_multicast))
    return send_first(out);
  for (const auto& to : out.to) {
    const Outgoing one{out.messages, {&to, 1}, out.dscp};
    if (!to.is_multicast() || leaves_by(sockets_.front(), out.interface)) send_first(one);
    for (const auto& further : further_)
      if (to.is_multicast() && leaves_by(further, out.interface)) further.send_all(one);
  }
}

void ParticipantSockets::send_first(const Outgoing& out) {
  sockets_.front().send_all(out, [this, &out](BytesView message, const Locator& to) {
    overflow_.send(message, to, out.dscp);
  });
}

bool ParticipantSockets::stays_here(const Locator& to) const {
  return to.is_loopback() || std::ranges::any_of(interfaces_, [&](const auto& interface) {
           return interface.address.address == to.address;
         });
}

bool ParticipantSockets::leaves_by(const UdpSocket& socket, std::size_t interface) const {
  return interface == kEveryInterface ||
         interfaces_[interface].address.address == socket.local().address;
}

LocatorList ParticipantSockets::everywhere(std::uint32_t port) const {
  LocatorList out;
  for (const auto& interface : interfaces_) {
    out.push_back(interface.address);
    out.back().port = port;
  }
  return out;
}

}  // namespace ddssec::rtps
