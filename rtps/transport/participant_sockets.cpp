#include "rtps/transport/participant_sockets.hpp"

#include <algorithm>

namespace ddssec::rtps {

Result<UdpSocket> ParticipantSockets::socket_at(std::span<const NetworkInterface> interfaces,
                                                std::uint32_t port, const Options& options) {
  auto address = interfaces.front().address;
  address.port = port;
  return interfaces.size() == 1 && !options.interfaces_may_change
             ? UdpSocket::on_interface(address, options.receive_buffer)
             : UdpSocket::everywhere(address, options.receive_buffer);
}

Result<std::unique_ptr<ParticipantSockets>> ParticipantSockets::open(
    DomainId domain, std::vector<NetworkInterface> interfaces, const Options& options) {
  for (int index = 0; index < ports::kMaxIndexes; ++index) {
    auto metatraffic = socket_at(interfaces, ports::metatraffic(domain, index), options);
    if (!metatraffic && metatraffic.error().code() == Code::rtps_port_taken) continue;
    if (!metatraffic) return std::unexpected(metatraffic.error());
    auto user = socket_at(interfaces, ports::user(domain, index), options);
    if (!user && user.error().code() == Code::rtps_port_taken) continue;
    if (!user) return std::unexpected(user.error());
    DDSSEC_ASSIGN_OR_RETURN(auto event_loop, EventLoop::create());
    std::unique_ptr<ParticipantSockets> out(
        new ParticipantSockets(std::move(event_loop), std::move(interfaces), index, options));
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
  group_ = group;
  return interface.address.address == interfaces_.front().address.address ? Status()
                                                                          : send_by(interface);
}

std::vector<Error> ParticipantSockets::use(std::vector<NetworkInterface> interfaces) {
  std::vector<Error> errors;
  const auto note = [&](const Status& status, const NetworkInterface& interface) {
    if (!status) errors.push_back(status.error().with_default_document(to_string({&interface, 1})));
  };
  // If they are the same ones again, they were gone meanwhile, and the system has forgotten their
  // memberships.
  const bool are_back = interfaces == interfaces_;
  if (group_)
    for (const auto& former : interfaces_)
      if (are_back || std::ranges::find(interfaces, former.address, &NetworkInterface::address) ==
                          interfaces.end())
        sockets_.back().leave(*group_, former.address);
  const auto former = std::exchange(interfaces_, std::move(interfaces));
  further_.clear();
  note(sockets_.front().use(interfaces_.front().address), interfaces_.front());
  for (const auto& interface : interfaces_) {
    const bool is_new = are_back || std::ranges::find(former, interface.address,
                                                      &NetworkInterface::address) == former.end();
    if (group_ && is_new) note(sockets_.back().join_also(*group_, interface.address), interface);
    if (group_ && &interface != &interfaces_.front()) note(send_by(interface), interface);
  }
  return errors;
}

Status ParticipantSockets::send_by(const NetworkInterface& interface) {
  DDSSEC_ASSIGN_OR_RETURN(auto udp_socket, UdpSocket::everywhere(interface.address));
  further_.push_back(std::move(udp_socket));
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

void ParticipantSockets::send_all(const OutgoingMessages& out) {
  if (interfaces_.size() == 1 || std::ranges::none_of(out.to, &Locator::is_multicast))
    return send_first(out);
  for (const auto& to : out.to) {
    const OutgoingMessages one{out.messages, {&to, 1}, out.dscp};
    if (!to.is_multicast() || leaves_by(sockets_.front(), out.interface)) send_first(one);
    for (const auto& further : further_)
      if (to.is_multicast() && leaves_by(further, out.interface)) further.send_all(one);
  }
}

void ParticipantSockets::send_first(const OutgoingMessages& out) {
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
