#include "plugins/cyclonedds/peers_with_keys.hpp"

namespace ddssec::cyclonedds {

PeersWithKeys& PeersWithKeys::of_process() {
  static auto& peers = *new PeersWithKeys;  // authentication's timer may ask while the process ends
  return peers;
}

void PeersWithKeys::met(spi::ParticipantCryptoHandle peer, spi::IdentityHandle identity) noexcept {
  const std::lock_guard lock(mutex_);
  try {
    peers_.try_emplace(peer.value, Peer{identity.value});
    by_identity_[identity.value] = peer.value;
  } catch (...) {
    // The registration itself stands.
  }
}

void PeersWithKeys::sent_keys(spi::ParticipantCryptoHandle peer) {
  const std::lock_guard lock(mutex_);
  if (const auto known = peers_.find(peer.value); known != peers_.end())
    known->second.sent_keys = true;
}

void PeersWithKeys::left(spi::ParticipantCryptoHandle peer) {
  const std::lock_guard lock(mutex_);
  const auto known = peers_.find(peer.value);
  if (known == peers_.end()) return;
  if (const auto named = by_identity_.find(known->second.identity);
      named != by_identity_.end() && named->second == peer.value)
    by_identity_.erase(named);
  peers_.erase(known);
}

bool PeersWithKeys::contains(spi::IdentityHandle identity) const {
  const std::lock_guard lock(mutex_);
  const auto named = by_identity_.find(identity.value);
  if (named == by_identity_.end()) return false;
  const auto known = peers_.find(named->second);
  return known != peers_.end() && known->second.sent_keys;
}

}  // namespace ddssec::cyclonedds
