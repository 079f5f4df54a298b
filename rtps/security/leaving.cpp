#include "rtps/security/leaving.hpp"

namespace ddssec::rtps {

void announce_leaving(SecurityCore& core, CryptoTokenExchange& exchange) {
  for (auto& [prefix, peer] : core.peers)
    if (peer.state.joined() != nullptr && peer.data.vendor == kVendorDdssec)
      exchange.send_notice(peer, message_class::kLeaving);
}

// A recorded message is not new in its session, and has no key in another one.
void listen_for_leaving(SecurityCore& core, CryptoTokenExchange& exchange) {
  exchange.listen({message_class::kLeaving}, [&core](Peer& peer, const GenericMessage&) {
    core.host.on_ended(peer.prefix());
  });
}

}  // namespace ddssec::rtps
