// The permissions handles of peers that the host holds. The core returns such a handle with the
// match of a local and a remote participant. If cryptography refuses to register the peer, there is
// no match, and the core drops the handle. Then the handle is returned with the peer's identity.
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <mutex>
#include <set>
#include <utility>
#include <vector>

#include "base/rollback.hpp"
#include "plugins/spi/handles.hpp"

namespace ddssec::cyclonedds {

/// The handles of the peers of one domain. Thread-safe.
class PeerPermissions {
 public:
  /// Notes a new handle. `peer` is the host's handle of the remote participant.
  void note(spi::IdentityHandle peer, spi::PermissionsHandle permissions) {
    const std::lock_guard lock(mutex_);
    const auto added = peer_of_.insert_or_assign(permissions, peer).first;
    Rollback forget_peer([&] { peer_of_.erase(added); });
    of_peers_.emplace(peer, permissions);
    forget_peer.release();
  }
  /// Forgets a handle that the host returns.
  void forget(spi::PermissionsHandle permissions) {
    const std::lock_guard lock(mutex_);
    const auto known = peer_of_.find(permissions);
    if (known == peer_of_.end()) return;
    of_peers_.erase({known->second, permissions});
    peer_of_.erase(known);
  }
  /// Forgets all handles of a peer that the host forgets. Returns those that it has not returned.
  std::vector<spi::PermissionsHandle> take(spi::IdentityHandle peer) {
    constexpr spi::PermissionsHandle kMin{std::numeric_limits<std::int64_t>::min()};
    const std::lock_guard lock(mutex_);
    std::vector<spi::PermissionsHandle> out;
    const auto first = of_peers_.lower_bound({peer, kMin});
    auto end = first;
    for (; end != of_peers_.end() && end->first == peer; ++end) out.push_back(end->second);
    of_peers_.erase(first, end);
    for (const auto permissions : out) peer_of_.erase(permissions);
    return out;
  }

 private:
  std::mutex mutex_;
  std::map<spi::PermissionsHandle, spi::IdentityHandle> peer_of_;
  std::set<std::pair<spi::IdentityHandle, spi::PermissionsHandle>> of_peers_;
};

}  // namespace ddssec::cyclonedds
