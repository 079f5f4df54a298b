#include "rtps/transport/host_sockets.hpp"

#include <algorithm>

namespace ddssec::rtps {

void HostSockets::send(BytesView message, const Locator& to, std::uint8_t dscp) {
  if (const auto* socket = socket_of({to.kind, 0, to.address}))
    socket->send_all({{&message, 1}, {&to, 1}, dscp});
}

UdpSocket* HostSockets::socket_of(Locator address) {
  const auto known = std::ranges::find(hosts_, address, &Host::address);
  if (known != hosts_.end()) {
    hosts_.splice(hosts_.begin(), hosts_, known);
    return &hosts_.front().socket;
  }
  auto opened = open_();
  if (!opened) return nullptr;
  opened->keep_no_input();
  if (hosts_.size() >= kMax) hosts_.pop_back();
  hosts_.push_front({address, std::move(*opened)});
  return &hosts_.front().socket;
}

}  // namespace ddssec::rtps
