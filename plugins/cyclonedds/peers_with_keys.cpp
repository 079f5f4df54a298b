#include "plugins/cyclonedds/peers_with_keys.hpp"

#include <utility>

namespace ddssec::cyclonedds {

PeersWithKeys& PeersWithKeys::of_process() {
  static auto& peers = *new PeersWithKeys;  // authentication's timer may ask while the process ends
  return peers;
}

void PeersWithKeys::met(spi::ParticipantCryptoHandle peer, spi::IdentityHandle identity) noexcept {
  const std::lock_guard lock(mutex_);
  try {
    if (peers_.try_emplace(peer.value, Peer{identity.value}).second) ++awaited_;
    by_identity_[identity.value] = peer.value;
  } catch (...) {
    // The registration itself stands.
  }
}

void PeersWithKeys::sent_keys(spi::ParticipantCryptoHandle peer) {
  const std::lock_guard lock(mutex_);
  const auto known = peers_.find(peer.value);
  if (known != peers_.end() && !std::exchange(known->second.sent_keys, true)) --awaited_;
}

void PeersWithKeys::left(spi::ParticipantCryptoHandle peer) {
  const std::lock_guard lock(mutex_);
  const auto known = peers_.find(peer.value);
  if (known == peers_.end()) return;
  if (const auto named = by_identity_.find(known->second.identity);
      named != by_identity_.end() && named->second == peer.value)
    by_identity_.erase(named);
  if (!known->second.sent_keys) --awaited_;
  std::erase_if(endpoints_, [&](const auto& entry) { return entry.second == peer.value; });
  peers_.erase(known);
}

void PeersWithKeys::matched(std::int64_t endpoint, spi::ParticipantCryptoHandle peer) noexcept {
  const std::lock_guard lock(mutex_);
  try {
    endpoints_[endpoint] = peer.value;
  } catch (...) {
    // As declared.
  }
}

void PeersWithKeys::forget(std::int64_t endpoint) {
  const std::lock_guard lock(mutex_);
  endpoints_.erase(endpoint);
}

void PeersWithKeys::heard(std::int64_t endpoint, std::chrono::nanoseconds now) {
  const std::lock_guard lock(mutex_);
  const auto known = endpoints_.find(endpoint);
  if (known == endpoints_.end()) return;
  if (const auto peer = peers_.find(known->second); peer != peers_.end())
    peer->second.last_heard = now;
}

const PeersWithKeys::Peer* PeersWithKeys::find(spi::IdentityHandle identity) const {
  const auto named = by_identity_.find(identity.value);
  if (named == by_identity_.end()) return nullptr;
  const auto known = peers_.find(named->second);
  return known == peers_.end() ? nullptr : &known->second;
}

std::chrono::nanoseconds PeersWithKeys::last_heard(spi::IdentityHandle identity) const {
  const std::lock_guard lock(mutex_);
  const auto* const peer = find(identity);
  return peer == nullptr ? std::chrono::nanoseconds{} : peer->last_heard;
}

bool PeersWithKeys::contains(spi::IdentityHandle identity) const {
  const std::lock_guard lock(mutex_);
  const auto* const peer = find(identity);
  return peer != nullptr && peer->sent_keys;
}

}  // namespace ddssec::cyclonedds
