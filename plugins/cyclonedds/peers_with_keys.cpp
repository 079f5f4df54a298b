#include "plugins/cyclonedds/peers_with_keys.hpp"

#include <algorithm>
#include <new>
#include <utility>

#include "base/rollback.hpp"

namespace ddssec::cyclonedds {
namespace {

// Records a fact for a host that has no way to handle an error. If memory runs out, the fact is not
// recorded; the header says for each fact what that means.
template <class F>
void if_memory_allows(const F& record) noexcept {
  try {
    record();
  } catch (const std::bad_alloc&) {
    return;
  }
}

}  // namespace

PeersWithKeys& PeersWithKeys::of_process() {
  // The object is never destroyed, because authentication's timer may ask at exit.
  static auto& peers = *new PeersWithKeys;
  return peers;
}

void PeersWithKeys::add_local(spi::ParticipantCryptoHandle local,
                              spi::IdentityHandle identity) noexcept {
  const std::lock_guard lock(mutex_);
  if_memory_allows([&] { local_of_[identity.value] = local.value; });
}

void PeersWithKeys::note_discovered(spi::ParticipantCryptoHandle peer, spi::IdentityHandle identity,
                                    spi::ParticipantCryptoHandle local,
                                    std::uint32_t builtin_endpoints) noexcept {
  const std::lock_guard lock(mutex_);
  if_memory_allows([&] {
    const auto [known, is_new] = peers_.try_emplace(peer.value, Peer{identity.value});
    Rollback forget_peer([&] {
      if (is_new) peers_.erase(known);
    });
    const auto [named, is_first] = by_identity_.try_emplace(identity.value, peer.value);
    Rollback forget_identity([&] {
      if (is_first) by_identity_.erase(named);
    });
    known->second.locals.insert(local.value);
    forget_identity.release();
    forget_peer.release();
    named->second = peer.value;
    known->second.has_all_endpoints = (builtin_endpoints & kSecureEndpoints) == kSecureEndpoints;
    if (is_new) ++awaited_;
  });
}

void PeersWithKeys::note_keys_sent(spi::ParticipantCryptoHandle peer,
                                   spi::ParticipantCryptoHandle local) noexcept {
  const std::lock_guard lock(mutex_);
  const auto known = peers_.find(peer.value);
  if (known == peers_.end()) return;
  if (!std::exchange(known->second.has_sent_keys, true)) --awaited_;
  if_memory_allows([&] { known->second.with_keys.insert(local.value); });
}

void PeersWithKeys::note_left(spi::ParticipantCryptoHandle participant) {
  const std::lock_guard lock(mutex_);
  std::erase_if(local_of_, [&](const auto& entry) { return entry.second == participant.value; });
  for (auto& [handle, peer] : peers_) {
    peer.locals.erase(participant.value);
    peer.with_keys.erase(participant.value);
  }
  const auto known = peers_.find(participant.value);
  if (known == peers_.end()) return;
  if (const auto named = by_identity_.find(known->second.identity);
      named != by_identity_.end() && named->second == participant.value)
    by_identity_.erase(named);
  if (!known->second.has_sent_keys) --awaited_;
  std::erase_if(endpoints_,
                [&](const auto& entry) { return entry.second.peer == participant.value; });
  peers_.erase(known);
}

void PeersWithKeys::add_builtin(std::int64_t endpoint,
                                spi::ParticipantCryptoHandle local) noexcept {
  const std::lock_guard lock(mutex_);
  if_memory_allows([&] { builtin_[endpoint] = local.value; });
}

void PeersWithKeys::note_matched(std::int64_t endpoint, spi::ParticipantCryptoHandle peer,
                                 std::int64_t own) noexcept {
  const std::lock_guard lock(mutex_);
  if_memory_allows([&] {
    const auto known = peers_.find(peer.value);
    const bool is_builtin = known != peers_.end() && builtin_.contains(own);
    const auto [entry, is_new] = endpoints_.try_emplace(endpoint, Endpoint{peer.value, own});
    Rollback forget_endpoint([&] {
      if (is_new) endpoints_.erase(entry);
    });
    if (is_builtin) known->second.matched.insert(own);
    forget_endpoint.release();
    entry->second = {peer.value, own};
  });
}

void PeersWithKeys::forget(std::int64_t endpoint) {
  const std::lock_guard lock(mutex_);
  if (const auto known = endpoints_.extract(endpoint)) {
    const auto peer = peers_.find(known.mapped().peer);
    if (peer == peers_.end()) return;
    auto& matched = peer->second.matched;
    if (const auto own = matched.find(known.mapped().own); own != matched.end()) matched.erase(own);
    return;
  }
  if (builtin_.erase(endpoint) == 0) return;
  for (auto& [handle, peer] : peers_) peer.matched.erase(endpoint);
}

void PeersWithKeys::note_heard(std::int64_t endpoint, std::chrono::nanoseconds now) {
  if (!awaits_keys()) return;
  const std::lock_guard lock(mutex_);
  const auto known = endpoints_.find(endpoint);
  if (known == endpoints_.end()) return;
  if (const auto peer = peers_.find(known->second.peer); peer != peers_.end())
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

bool PeersWithKeys::has_sent_keys(spi::IdentityHandle identity) const {
  const std::lock_guard lock(mutex_);
  const auto* const peer = find(identity);
  return peer != nullptr && peer->has_sent_keys;
}

bool PeersWithKeys::has_sent_keys(spi::IdentityHandle identity, spi::IdentityHandle local) const {
  const std::lock_guard lock(mutex_);
  const auto* const peer = find(identity);
  const auto known = local_of_.find(local.value);
  return peer != nullptr && known != local_of_.end() && peer->with_keys.contains(known->second);
}

bool PeersWithKeys::has_sent_keys(spi::ParticipantCryptoHandle peer,
                                  spi::ParticipantCryptoHandle local) const {
  const std::lock_guard lock(mutex_);
  const auto known = peers_.find(peer.value);
  return known != peers_.end() && known->second.with_keys.contains(local.value);
}

bool PeersWithKeys::is_matched(spi::IdentityHandle identity) const {
  const std::lock_guard lock(mutex_);
  const auto* const peer = find(identity);
  if (peer == nullptr || !peer->has_all_endpoints) return true;
  return std::ranges::all_of(builtin_, [&](const auto& own) {
    return !peer->locals.contains(own.second) || peer->matched.contains(own.first);
  });
}

}  // namespace ddssec::cyclonedds
