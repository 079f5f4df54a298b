#include "plugins/authentication/identity_table.hpp"

#include <algorithm>

#include "base/rollback.hpp"

namespace ddssec::authentication {
namespace {

std::unexpected<Error> too_many(Code code, std::size_t most) {
  return fail(code, {.expected = "at most " + std::to_string(most)});
}

template <class Map>
Result<const typename Map::mapped_type*> find_live(const Map& map, spi::IdentityHandle handle) {
  const auto found = map.find(handle.value);
  if (found == map.end()) return fail(Code::unknown_identity);
  const auto& identity = found->second;
  if (identity.has_ended)
    return fail(Code::identity_ended, {.field = "notAfter",
                                       .found = to_string(identity.ends.value_or(WallTime())),
                                       .note = identity.first_to_end});
  return &identity;
}

}  // namespace

Result<const IdentityTable::Local*> IdentityTable::live_local(spi::IdentityHandle handle) const {
  return find_live(locals_, handle);
}

Result<const IdentityTable::Remote*> IdentityTable::live_remote(spi::IdentityHandle handle) const {
  return find_live(remotes_, handle);
}

void IdentityTable::set_end(std::int64_t handle, Common& identity, WallTime end,
                            std::string whose) {
  if (identity.ends && *identity.ends <= end) return;
  // First what may want memory: an end is never lost.
  if (!identity.has_ended) ends_.emplace(end, handle);
  drop_end(handle, identity);
  identity.ends = end;
  identity.first_to_end = std::move(whose);
}

void IdentityTable::drop_end(std::int64_t handle, const Common& identity) {
  if (identity.ends) ends_.erase({*identity.ends, handle});
}

Result<spi::IdentityHandle> IdentityTable::add_local(std::shared_ptr<LocalIdentity> identity,
                                                     const pki::ChainValid& chain) {
  const std::unique_lock lock(mutex_);
  if (locals_.size() >= most_local_) return too_many(Code::too_many_local_identities, most_local_);
  const auto handle = next_handle();
  auto& local = locals_[handle];
  Rollback forget([&] { locals_.erase(handle); });
  local.identity = std::move(identity);
  set_end(handle, local, chain.not_after(), chain.first_to_expire());
  forget.release();
  return spi::IdentityHandle{handle};
}

Result<std::shared_ptr<LocalIdentity>> IdentityTable::local(spi::IdentityHandle handle) const {
  const std::shared_lock lock(mutex_);
  return DDSSEC_TRY(live_local(handle))->identity;
}

Result<spi::IdentityHandle> IdentityTable::admit_remote(RemoteClaim claim) {
  const std::unique_lock lock(mutex_);
  if (const auto known = remote_by_guid_.find(claim.guid); known != remote_by_guid_.end()) {
    const spi::IdentityHandle handle{known->second};
    DDSSEC_TRY(live_remote(handle));
    Remote& remote = remotes_.at(handle.value);
    if (remote.claim.identity_token == claim.identity_token) return handle;
    if (remote.authenticated)
      return fail(Code::identity_token_changed,
                  {.expected = remote.claim.subject, .found = claim.subject});
    remote.claim = std::move(claim);
    return handle;
  }
  if (remotes_.size() >= most_remote_)
    return too_many(Code::too_many_remote_identities, most_remote_);
  const auto handle = next_handle();
  const auto known = remote_by_guid_.emplace(claim.guid, handle).first;
  Rollback forget([&] { remote_by_guid_.erase(known); });
  remotes_[handle].claim = std::move(claim);
  forget.release();
  return spi::IdentityHandle{handle};
}

Result<std::shared_ptr<Pair>> IdentityTable::pair(spi::IdentityHandle local,
                                                  spi::IdentityHandle remote,
                                                  const spi::Challenge& own_challenge) {
  const std::unique_lock lock(mutex_);
  const auto* our = DDSSEC_TRY(live_local(local));
  DDSSEC_TRY(live_remote(remote));
  auto& theirs = remotes_.at(remote.value);
  if (const auto known = theirs.pairs.find(local.value); known != theirs.pairs.end())
    return known->second;
  std::shared_ptr<Pair> pair(
      new Pair{local, remote, our->identity, theirs.claim.guid, own_challenge, {}});
  theirs.pairs.emplace(local.value, pair);
  return pair;
}

Result<std::shared_ptr<Pair>> IdentityTable::pair(spi::IdentityHandle local,
                                                  spi::IdentityHandle remote) const {
  const std::shared_lock lock(mutex_);
  DDSSEC_TRY(live_local(local));
  const auto* theirs = DDSSEC_TRY(live_remote(remote));
  const auto found = theirs->pairs.find(local.value);
  if (found == theirs->pairs.end())
    return fail(Code::unknown_identity, {.note = "validate_remote_identity was not called"});
  return found->second;
}

Result<std::shared_ptr<Pair>> IdentityTable::pair_of(spi::HandshakeHandle handle) const {
  const std::shared_lock lock(mutex_);
  const auto found = handshakes_.find(handle.value);
  if (found == handshakes_.end()) return fail(Code::unknown_handshake);
  DDSSEC_TRY(live_local(found->second->local_handle));
  DDSSEC_TRY(live_remote(found->second->remote_handle));
  return found->second;
}

spi::HandshakeHandle IdentityTable::add_handshake(const std::shared_ptr<Pair>& pair) {
  const std::unique_lock lock(mutex_);
  const auto handle = next_handle();
  // Meanwhile the host may have returned an identity: then nobody will ask for the handshake.
  const auto remote = remotes_.find(pair->remote_handle.value);
  if (remote == remotes_.end() || !remote->second.pairs.contains(pair->local_handle.value))
    return {handle};
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

void IdentityTable::drop_handshakes(const Pair& pair) {
  const auto handles = handshakes_of_.find(&pair);
  if (handles == handshakes_of_.end()) return;
  for (const auto handle : handles->second) handshakes_.erase(handle);
  handshakes_of_.erase(handles);
}

void IdentityTable::note_authenticated(spi::IdentityHandle handle, const pki::ChainValid& chain) {
  const std::unique_lock lock(mutex_);
  const auto found = remotes_.find(handle.value);
  if (found == remotes_.end()) return;
  auto subject = chain.certificate().subject();
  set_end(handle.value, found->second, chain.not_after(), chain.first_to_expire());
  found->second.authenticated = true;
  found->second.claim.subject = std::move(subject);
}

bool IdentityTable::remove(spi::IdentityHandle handle) {
  const std::unique_lock lock(mutex_);
  if (const auto found = remotes_.find(handle.value); found != remotes_.end()) {
    for (const auto& [local, pair] : found->second.pairs) drop_handshakes(*pair);
    drop_end(handle.value, found->second);
    remote_by_guid_.erase(found->second.claim.guid);
    remotes_.erase(found);
    return true;
  }
  const auto found = locals_.find(handle.value);
  if (found == locals_.end()) return false;
  for (auto& [value, remote] : remotes_) {
    const auto pair = remote.pairs.find(handle.value);
    if (pair == remote.pairs.end()) continue;
    drop_handshakes(*pair->second);
    remote.pairs.erase(pair);
  }
  drop_end(handle.value, found->second);
  locals_.erase(found);
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

std::vector<IdentityTable::Ended> IdentityTable::ended_by(WallTime now) const {
  const std::shared_lock lock(mutex_);
  std::vector<Ended> ended;
  for (const auto& [end, handle] : ends_) {
    if (end > now) break;
    Ended entry{{handle}, {}, {}, end};
    if (const auto remote = remotes_.find(handle); remote != remotes_.end()) {
      entry.peer = {remote->second.claim.subject, remote->second.claim.guid.to_string()};
      entry.whose = remote->second.first_to_end;
    } else if (const auto local = locals_.find(handle); local != locals_.end()) {
      entry.peer.guid = local->second.identity->guid().to_string();
      entry.whose = local->second.first_to_end;
    }
    ended.push_back(std::move(entry));
  }
  return ended;
}

void IdentityTable::mark_ended(std::span<const Ended> ended) {
  const std::unique_lock lock(mutex_);
  for (const auto& one : ended) {
    ends_.erase({one.end, one.handle.value});
    if (Common* identity = find(one.handle.value)) identity->has_ended = true;
  }
}

std::vector<spi::IdentityHandle> IdentityTable::peers_of_only(spi::IdentityHandle local) const {
  const std::shared_lock lock(mutex_);
  std::vector<spi::IdentityHandle> peers;
  for (const auto& [handle, remote] : remotes_)
    if (remote.pairs.size() == 1 && remote.pairs.contains(local.value)) peers.push_back({handle});
  return peers;
}

PeerName IdentityTable::name_of(spi::IdentityHandle remote) const {
  const std::shared_lock lock(mutex_);
  const auto found = remotes_.find(remote.value);
  if (found == remotes_.end()) return {};
  return {found->second.claim.subject, found->second.claim.guid.to_string()};
}

}  // namespace ddssec::authentication
