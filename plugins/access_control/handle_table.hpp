// The permissions handles in use.
#pragma once

#include <algorithm>
#include <memory>
#include <mutex>
#include <set>
#include <shared_mutex>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/rollback.hpp"
#include "plugins/access_control/permissions_holder.hpp"

namespace ddssec::access_control {

using Holder = std::shared_ptr<PermissionsHolder>;
using Entries = std::vector<std::pair<spi::PermissionsHandle, Holder>>;
using Participants = std::set<const LocalParticipant*>;

/// Thread-safe; several threads may look up handles at once.
class HandleTable {
 public:
  explicit HandleTable(std::size_t max_handles) : max_(max_handles) {}

  Result<spi::PermissionsHandle> add(Holder holder) {
    const std::unique_lock lock(mutex_);
    if (holders_.size() >= max_) return fail(Code::too_many_permissions_handles);
    const spi::PermissionsHandle handle{++last_};
    const auto added = holders_.emplace(handle.value, std::move(holder)).first;
    Rollback forget([&] { holders_.erase(added); });
    const auto& kept = *added->second;
    if (!kept.remote()) local_of_[kept.participant()->identity.value] = handle.value;
    forget.release();
    return handle;
  }

  Holder find(spi::PermissionsHandle handle) const {
    const std::shared_lock lock(mutex_);
    const auto entry = holders_.find(handle.value);
    return entry == holders_.end() ? nullptr : entry->second;
  }

  /// Returns nullptr for an unknown handle and for that of a remote participant.
  std::shared_ptr<LocalParticipant> find_participant(spi::PermissionsHandle handle) const {
    const auto holder = find(handle);
    return holder && !holder->remote() ? holder->participant() : nullptr;
  }

  Holder find_local(spi::IdentityHandle identity) const {
    const std::shared_lock lock(mutex_);
    const auto entry = local_of_.find(identity.value);
    return entry == local_of_.end() ? nullptr : holders_.at(entry->second);
  }

  /// Returns the peers of a local participant.
  std::vector<Holder> peers_of(const LocalParticipant& local) const {
    const std::shared_lock lock(mutex_);
    std::vector<Holder> out;
    for (const auto& [value, holder] : holders_)
      if (holder->remote() && holder->participant().get() == &local) out.push_back(holder);
    return out;
  }

  bool remove(spi::PermissionsHandle handle) {
    const std::unique_lock lock(mutex_);
    std::erase_if(local_of_, [&](const auto& entry) { return entry.second == handle.value; });
    return holders_.erase(handle.value) == 1;
  }

  /// Returns all entries, in the order of their handles.
  Entries all() const {
    const std::shared_lock lock(mutex_);
    Entries out;
    for (const auto& [value, holder] : holders_)
      out.emplace_back(spi::PermissionsHandle{value}, holder);
    std::ranges::sort(out, {}, [](const auto& entry) { return entry.first; });
    return out;
  }

 private:
  const std::size_t max_;
  mutable std::shared_mutex mutex_;
  std::unordered_map<std::int64_t, Holder> holders_;
  std::unordered_map<std::int64_t, std::int64_t> local_of_;  ///< identity -> permissions
  std::int64_t last_ = 0;
};

/// Returns the peers of the local participants in `gone`, in the order of `all`. Peers stay if
/// another local participant with valid permissions knows them under the same identity, because a
/// host that gives its participants one remote identity knows each peer only once.
inline std::vector<spi::PermissionsHandle> peers_of_only(const Participants& gone,
                                                         const Entries& all, WallTime now) {
  Participants staying;
  for (const auto& [handle, holder] : all)
    if (!holder->remote() && holder->grant(now)) staying.insert(holder->participant().get());
  std::set<spi::IdentityHandle> kept;
  for (const auto& [handle, holder] : all)
    if (holder->remote() && staying.contains(holder->participant().get()))
      kept.insert(*holder->remote());
  std::vector<spi::PermissionsHandle> peers;
  for (const auto& [handle, holder] : all)
    if (holder->remote() && gone.contains(holder->participant().get()) &&
        !kept.contains(*holder->remote()))
      peers.push_back(handle);
  return peers;
}

}  // namespace ddssec::access_control
