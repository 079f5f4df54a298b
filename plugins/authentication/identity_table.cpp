#include "plugins/authentication/identity_table.hpp"

#include <algorithm>
#include <atomic>

#include "base/rollback.hpp"

namespace ddssec::authentication {
namespace {

template <class Map>
Result<const typename Map::mapped_type*> find_live(const Map& map, spi::IdentityHandle handle) {
  const auto found = map.find(handle.value);
  if (found == map.end()) return fail(Code::unknown_identity);
  const auto& identity = found->second;
  if (identity.revoked) return std::unexpected(*identity.revoked);
  if (identity.has_ended)
    return fail(Code::identity_ended, {.field = "notAfter",
                                       .found = to_string(identity.ends.value_or(WallTime())),
                                       .note = identity.first_to_end});
  return &identity;
}

}  // namespace

std::int64_t IdentityTable::next_handle() {
  static std::atomic<std::int64_t> last = 0;
  return ++last;
}

Result<const IdentityTable::Local*> IdentityTable::live_local(spi::IdentityHandle handle) const {
  return find_live(locals_, handle);
}

Result<const IdentityTable::Remote*> IdentityTable::live_remote(spi::IdentityHandle handle) const {
  return find_live(remotes_, handle);
}

void IdentityTable::set_end(std::int64_t handle, Common& identity, WallTime end,
                            std::string whose) {
  if (identity.has_ended || identity.ends == end) return;
  // The step that can run out of memory comes first, because an expiry must never be lost.
  ends_.emplace(end, handle);
  drop_end(handle, identity);
  identity.ends = end;
  identity.first_to_end = std::move(whose);
}

void IdentityTable::drop_end(std::int64_t handle, const Common& identity) {
  if (identity.ends) ends_.erase({*identity.ends, handle});
}

void IdentityTable::set_renewed(spi::IdentityHandle handle, const pki::ValidChain& chain) {
  const std::unique_lock lock(mutex_);
  const auto local = locals_.find(handle.value);
  if (local == locals_.end() || local->second.has_ended) return;
  set_end(handle.value, local->second, chain.not_after(), chain.first_to_expire());
}

Result<spi::IdentityHandle> IdentityTable::add_local(std::shared_ptr<OwnIdentity> identity,
                                                     const pki::ValidChain& chain) {
  const std::unique_lock lock(mutex_);
  if (locals_.size() >= max_local_)
    return fail(Code::too_many_local_identities,
                {.expected = "at most " + std::to_string(max_local_)});
  const auto handle = next_handle();
  auto& local = locals_[handle];
  Rollback forget([&] { locals_.erase(handle); });
  local.identity = std::move(identity);
  set_end(handle, local, chain.not_after(), chain.first_to_expire());
  forget.release();
  return spi::IdentityHandle{handle};
}

PeerName IdentityTable::Remote::name() const {
  return {claim.subject, claim.guid.to_string(),
          authenticated ? PeerProof::authenticated : PeerProof::claimed};
}

Result<std::shared_ptr<OwnIdentity>> IdentityTable::local(spi::IdentityHandle handle) const {
  const std::shared_lock lock(mutex_);
  DDSSEC_ASSIGN_OR_RETURN(const auto local, live_local(handle));
  return local->identity;
}

// An announcement proves nothing, and anyone may have sent the first one. What a handshake has
// proven stays.
Status IdentityTable::renew_claim(spi::IdentityHandle handle, RemoteClaim claim) {
  DDSSEC_RETURN_IF_ERROR(live_remote(handle));
  Remote& remote = remotes_.at(handle.value);
  if (!remote.authenticated) remote.claim = std::move(claim);
  return {};
}

Result<std::shared_ptr<IdentityPair>> IdentityTable::admit_remote(
    spi::IdentityHandle local_handle, RemoteClaim claim, const spi::Challenge& own_challenge) {
  const std::unique_lock lock(mutex_);
  DDSSEC_RETURN_IF_ERROR(live_local(local_handle));
  Local& local = locals_.at(local_handle.value);
  if (const auto known = local.remotes.find(claim.guid); known != local.remotes.end()) {
    DDSSEC_RETURN_IF_ERROR(renew_claim({known->second}, std::move(claim)));
    return remotes_.at(known->second).pair;
  }
  DDSSEC_RETURN_IF_ERROR(local.counts.check_claim(claim.guid, remote_limits_));
  const auto handle = next_handle();
  std::shared_ptr<IdentityPair> pair(
      new IdentityPair{local_handle, {handle}, local.identity, claim.guid, own_challenge, {}});
  const auto known = local.remotes.emplace(claim.guid, handle).first;
  Rollback forget([&] { local.remotes.erase(known); });
  Remote& remote = remotes_[handle];
  remote.claim = std::move(claim);
  remote.pair = pair;
  local.counts.add_claim();
  forget.release();
  return pair;
}

Result<std::shared_ptr<IdentityPair>> IdentityTable::pair(spi::IdentityHandle local,
                                                          spi::IdentityHandle remote) const {
  const std::shared_lock lock(mutex_);
  DDSSEC_RETURN_IF_ERROR(live_local(local));
  DDSSEC_ASSIGN_OR_RETURN(const auto live, live_remote(remote));
  const auto& pair = live->pair;
  if (pair->local_handle != local)
    return fail(Code::unknown_identity, {.note = "validate_remote_identity was not called"});
  return pair;
}

Result<std::shared_ptr<IdentityPair>> IdentityTable::pair_of(spi::HandshakeHandle handle) const {
  const std::shared_lock lock(mutex_);
  const auto found = handshakes_.find(handle.value);
  if (found == handshakes_.end()) return fail(Code::unknown_handshake);
  DDSSEC_RETURN_IF_ERROR(live_local(found->second->local_handle));
  DDSSEC_RETURN_IF_ERROR(live_remote(found->second->remote_handle));
  return found->second;
}

spi::HandshakeHandle IdentityTable::add_handshake(const std::shared_ptr<IdentityPair>& pair) {
  const std::unique_lock lock(mutex_);
  const auto handle = next_handle();
  // The host may have returned the identity meanwhile. The handshake can then no longer be used,
  // and is not added.
  if (!remotes_.contains(pair->remote_handle.value)) return {handle};
  const auto added = handshakes_.emplace(handle, pair).first;
  Rollback forget([&] { handshakes_.erase(added); });
  handshakes_of_[pair.get()].push_back(handle);
  forget.release();
  return {handle};
}

bool IdentityTable::remove_handshake(spi::HandshakeHandle handle) {
  const std::unique_lock lock(mutex_);
  const auto found = handshakes_.find(handle.value);
  if (found == handshakes_.end()) return false;
  std::erase(handshakes_of_[found->second.get()], handle.value);
  handshakes_.erase(found);
  return true;
}

void IdentityTable::drop_handshakes(const IdentityPair& pair) {
  const auto handles = handshakes_of_.find(&pair);
  if (handles == handshakes_of_.end()) return;
  for (const auto handle : handles->second) handshakes_.erase(handle);
  handshakes_of_.erase(handles);
}

void IdentityTable::set_end_of(std::int64_t handle, Remote& remote, const Proofs& proofs) {
  const bool ends_with_ours =
      !remote.keeps_session && proofs.own.not_after() < proofs.peer.not_after();
  const auto& first = ends_with_ours ? proofs.own : proofs.peer;
  set_end(handle, remote, first.not_after(), first.first_to_expire());
  remote.ends_with_ours = ends_with_ours;
}

void IdentityTable::set_verified_again(spi::IdentityHandle handle, const Proofs& proofs) {
  const std::unique_lock lock(mutex_);
  const auto found = remotes_.find(handle.value);
  if (found == remotes_.end() || found->second.has_ended) return;
  auto& remote = found->second;
  // The peer may have authenticated again meanwhile, with another certificate.
  if (remote.latest() == proofs.peer.certificate() && remote.own_seen == proofs.own.certificate())
    set_end_of(handle.value, remote, proofs);
}

void IdentityTable::extend_by_renewal_list(spi::IdentityHandle handle, const Proofs& proofs) {
  auto peer = proofs.peer.certificate();
  auto own = proofs.own.certificate();
  const std::unique_lock lock(mutex_);
  const auto found = remotes_.find(handle.value);
  if (found == remotes_.end() || found->second.has_ended || !found->second.authenticated) return;
  auto& remote = found->second;
  set_end_of(handle.value, remote, proofs);
  if (remote.latest() != peer) remote.listed = std::move(peer);
  remote.own_seen = std::move(own);
}

Status IdentityTable::set_authenticated(spi::IdentityHandle handle, const Proofs& proofs) {
  const auto& [chain, own, peer_keeps_session, peer_reads_lists] = proofs;
  const std::unique_lock lock(mutex_);
  const auto found = remotes_.find(handle.value);
  if (found == remotes_.end()) return {};
  auto& remote = found->second;
  auto& counts = locals_.at(remote.pair->local_handle.value).counts;
  if (!remote.authenticated)
    DDSSEC_RETURN_IF_ERROR(counts.check_authenticated(remote.pair->remote_guid, remote_limits_));
  auto subject = chain.certificate().subject();
  auto certificate = chain.certificate();
  remote.keeps_session = peer_keeps_session;
  remote.reads_lists = peer_reads_lists;
  set_end_of(handle.value, remote, proofs);
  if (!remote.authenticated) counts.authenticate(remote.pair->remote_guid, subject);
  remote.authenticated = std::move(certificate);
  remote.listed.reset();
  remote.own_seen = own.certificate();
  remote.claim.subject = std::move(subject);
  return {};
}

void IdentityTable::forget(Remotes::iterator remote) {
  drop_handshakes(*remote->second.pair);
  drop_end(remote->first, remote->second);
  remotes_.erase(remote);
}

std::shared_ptr<IdentityPair> IdentityTable::pair_of(spi::IdentityHandle handle) const {
  const std::shared_lock lock(mutex_);
  const auto remote = remotes_.find(handle.value);
  return remote == remotes_.end() ? nullptr : remote->second.pair;
}

bool IdentityTable::remove(spi::IdentityHandle handle) {
  const std::unique_lock lock(mutex_);
  if (const auto remote = remotes_.find(handle.value); remote != remotes_.end()) {
    const auto& pair = *remote->second.pair;
    auto& local = locals_.at(pair.local_handle.value);
    local.remotes.erase(pair.remote_guid);
    local.counts.remove(pair.remote_guid, remote->second.authenticated.has_value());
    forget(remote);
    return true;
  }
  const auto local = locals_.find(handle.value);
  if (local == locals_.end()) return false;
  for (const auto& [guid, remote] : local->second.remotes) forget(remotes_.find(remote));
  drop_end(handle.value, local->second);
  locals_.erase(local);
  return true;
}

std::optional<WallTime> IdentityTable::next_end() const {
  const std::shared_lock lock(mutex_);
  if (ends_.empty()) return std::nullopt;
  return ends_.begin()->first;
}

IdentityTable::Common* IdentityTable::find(std::int64_t handle) {
  if (const auto local = locals_.find(handle); local != locals_.end()) return &local->second;
  const auto remote = remotes_.find(handle);
  return remote == remotes_.end() ? nullptr : &remote->second;
}

std::vector<IdentityTable::EndedIdentity> IdentityTable::ended_by(WallTime now,
                                                                  spi::IdentityHandle local) const {
  const std::shared_lock lock(mutex_);
  std::vector<EndedIdentity> ended;
  for (const auto& [end, handle] : ends_) {
    if (end > now) break;
    const auto remote = remotes_.find(handle);
    const bool is_remote = remote != remotes_.end();
    const auto owner = is_remote ? remote->second.pair->local_handle : spi::IdentityHandle{handle};
    if (local && owner != local) continue;
    if (is_remote) {
      const auto& one = remote->second;
      ended.push_back({{handle}, one.name(), one.first_to_end, end, one.ends_with_ours});
    } else {
      const auto& own = locals_.at(handle);
      ended.push_back({{handle}, our_name(own.identity->guid()), own.first_to_end, end});
    }
  }
  return ended;
}

void IdentityTable::mark_ended(std::span<const EndedIdentity> ended) {
  const std::unique_lock lock(mutex_);
  for (const auto& one : ended) {
    ends_.erase({one.end, one.handle.value});
    if (Common* identity = find(one.handle.value)) identity->has_ended = true;
  }
}

std::vector<IdentityTable::OwnIdentityEntry> IdentityTable::locals(spi::IdentityHandle one) const {
  const std::shared_lock lock(mutex_);
  std::vector<OwnIdentityEntry> locals;
  for (const auto& [handle, local] : locals_)
    if (!local.has_ended && (!one || one.value == handle))
      locals.push_back({{handle}, local.identity});
  return locals;
}

std::vector<std::shared_ptr<IdentityPair>> IdentityTable::pairs_of(
    spi::IdentityHandle handle) const {
  const std::shared_lock lock(mutex_);
  std::vector<std::shared_ptr<IdentityPair>> pairs;
  const auto local = locals_.find(handle.value);
  if (local == locals_.end()) return pairs;
  for (const auto& [guid, remote] : local->second.remotes)
    pairs.push_back(remotes_.at(remote).pair);
  return pairs;
}

std::vector<IdentityTable::AuthenticatedPeer> IdentityTable::authenticated_with(
    spi::IdentityHandle handle) const {
  const std::shared_lock lock(mutex_);
  std::vector<AuthenticatedPeer> peers;
  const auto local = locals_.find(handle.value);
  if (local == locals_.end()) return peers;
  for (const auto& [guid, value] : local->second.remotes)
    if (const auto& remote = remotes_.at(value); remote.authenticated && !remote.has_ended)
      peers.push_back(remote.as_authenticated(value));
  return peers;
}

IdentityTable::AuthenticatedPeer IdentityTable::Remote::as_authenticated(
    std::int64_t handle) const {
  return {{handle}, name(), *authenticated, listed, *own_seen, reads_lists};
}

std::optional<IdentityTable::AuthenticatedPeer> IdentityTable::authenticated(
    spi::IdentityHandle handle) const {
  const std::shared_lock lock(mutex_);
  const auto remote = remotes_.find(handle.value);
  if (remote == remotes_.end() || !remote->second.authenticated || remote->second.has_ended)
    return std::nullopt;
  return remote->second.as_authenticated(handle.value);
}

void IdentityTable::mark_revoked(std::span<const RevokedIdentity> revoked) {
  const std::unique_lock lock(mutex_);
  for (const auto& one : revoked) {
    Common* identity = find(one.handle.value);
    if (identity == nullptr) continue;
    drop_end(one.handle.value, *identity);
    identity->has_ended = true;
    identity->revoked = one.reason;
  }
}

std::vector<spi::IdentityHandle> IdentityTable::peers_of(spi::IdentityHandle handle) const {
  const std::shared_lock lock(mutex_);
  std::vector<spi::IdentityHandle> peers;
  const auto local = locals_.find(handle.value);
  if (local == locals_.end()) return peers;
  for (const auto& [guid, remote] : local->second.remotes)
    if (!remotes_.at(remote).has_ended) peers.push_back({remote});
  return peers;
}

PeerName IdentityTable::name_of(spi::IdentityHandle remote) const {
  const std::shared_lock lock(mutex_);
  const auto found = remotes_.find(remote.value);
  if (found == remotes_.end()) return {};
  return found->second.name();
}

}  // namespace ddssec::authentication
