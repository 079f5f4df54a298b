#include "plugins/cyclonedds/remote_identities.hpp"

#include <algorithm>
#include <atomic>

#include "base/rollback.hpp"

namespace ddssec::cyclonedds {

using spi::IdentityHandle;

IdentityHandle RemoteIdentities::note(IdentityHandle local, const Guid& guid, IdentityHandle pair) {
  const std::lock_guard lock(mutex_);
  const auto [named, is_new_pair] = guid_of_.try_emplace(pair, guid);
  Rollback forget_pair([&] {
    if (is_new_pair) guid_of_.erase(named);
  });
  const auto [remote, is_new] = remotes_.try_emplace(guid, Remote{pair});
  Rollback forget_remote([&] {
    if (is_new) remotes_.erase(remote);
  });
  remote->second.pairs[local] = pair;
  forget_remote.release();
  forget_pair.release();
  return remote->second.of_host;
}

IdentityHandle RemoteIdentities::note_refused(const Guid& guid) {
  const std::lock_guard lock(mutex_);
  if (const auto known = remotes_.find(guid); known != remotes_.end()) return known->second.of_host;
  static std::atomic<std::int64_t> last = 0;
  const IdentityHandle own{--last};  // negative, because plugins use no such handles
  const auto named = guid_of_.try_emplace(own, guid).first;
  Rollback forget([&] { guid_of_.erase(named); });
  remotes_.try_emplace(guid, Remote{own});
  forget.release();
  return own;
}

const RemoteIdentities::Remote* RemoteIdentities::find(IdentityHandle handle) const {
  const auto guid = guid_of_.find(handle);
  if (guid == guid_of_.end()) return nullptr;
  const auto remote = remotes_.find(guid->second);
  return remote == remotes_.end() ? nullptr : &remote->second;
}

IdentityHandle RemoteIdentities::pair(IdentityHandle local, IdentityHandle handle) const {
  const std::lock_guard lock(mutex_);
  const auto* const remote = find(handle);
  if (remote == nullptr || remote->of_host != handle) return handle;
  const auto known = remote->pairs.find(local);
  return known == remote->pairs.end() ? handle : known->second;
}

std::optional<Guid> RemoteIdentities::guid(IdentityHandle of_host) const {
  const std::lock_guard lock(mutex_);
  const auto* const remote = find(of_host);
  if (remote == nullptr || remote->of_host != of_host) return std::nullopt;
  return guid_of_.at(of_host);
}

bool RemoteIdentities::has_discovered(IdentityHandle local, const Guid& remote) const {
  const std::lock_guard lock(mutex_);
  const auto known = remotes_.find(remote);
  return known != remotes_.end() && known->second.pairs.contains(local);
}

std::vector<std::pair<IdentityHandle, Guid>> RemoteIdentities::all() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::pair<IdentityHandle, Guid>> out;
  out.reserve(remotes_.size());
  for (const auto& [guid, remote] : remotes_) out.emplace_back(remote.of_host, guid);
  return out;
}

std::vector<IdentityHandle> RemoteIdentities::take(IdentityHandle handle) {
  const std::lock_guard lock(mutex_);
  const auto* const remote = find(handle);
  if (remote == nullptr || remote->of_host != handle) {
    forget_local(handle);
    return {handle};
  }
  std::vector<IdentityHandle> pairs;
  for (const auto& [local, pair] : remote->pairs) pairs.push_back(pair);
  remotes_.erase(guid_of_.at(handle));
  guid_of_.erase(handle);
  for (const auto pair : pairs) guid_of_.erase(pair);
  return pairs;
}

void RemoteIdentities::forget_local(IdentityHandle local) {
  ended_locals_.erase(local);
  for (auto& [guid, remote] : remotes_) {
    const auto pair = remote.pairs.extract(local);
    if (pair && pair.mapped() != remote.of_host) guid_of_.erase(pair.mapped());
  }
}

// True if a local participant that has not ended has discovered the remote participant of this pair
// too.
bool RemoteIdentities::stays(const Remote& remote, IdentityHandle pair) const {
  const auto ended = [&](const auto& entry) { return ended_locals_.contains(entry.first); };
  const auto own = std::ranges::find(remote.pairs, pair, [](auto& entry) { return entry.second; });
  return own != remote.pairs.end() && ended(*own) && !std::ranges::all_of(remote.pairs, ended);
}

bool RemoteIdentities::has_ended(IdentityHandle local) const {
  const std::lock_guard lock(mutex_);
  return ended_locals_.contains(local);
}

RemoteIdentities::HandlesToRevoke RemoteIdentities::to_revoke(
    std::span<const IdentityHandle> ended) {
  const std::lock_guard lock(mutex_);
  HandlesToRevoke out;
  for (const auto handle : ended)
    if (find(handle) == nullptr && ended_locals_.insert(handle).second)
      out.locals.push_back(handle);
  std::set<IdentityHandle> told;
  for (const auto handle : ended) {
    const auto* const remote = find(handle);
    if (remote == nullptr || stays(*remote, handle)) continue;
    if (told.insert(remote->of_host).second) out.remotes.push_back(remote->of_host);
  }
  return out;
}

}  // namespace ddssec::cyclonedds
