// One handle of a remote participant for the host, one for each pair in the engine.
#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "base/ids.hpp"
#include "plugins/spi/handles.hpp"

namespace ddssec::cyclonedds {

/// Cyclone's core has one identity handle for a remote participant, however many of its own
/// participants met it: it keeps the last that it was given, asserts that all are the same and
/// returns it once. The engine has one for each pair of a local and a remote participant. All calls
/// between name the local one as well, or a handshake. Thread-safe.
class RemoteIdentities {
 public:
  /// Remembers the engine's handle of a pair. The host's handle for the remote: that of the first
  /// pair, as long as the host keeps it.
  spi::IdentityHandle note(spi::IdentityHandle local, const Guid& remote, spi::IdentityHandle pair);

  /// The host's handle for a remote that the engine did not admit: the one that the host has, or
  /// one of our own, unique in the process, behind which is nothing yet.
  spi::IdentityHandle note_refused(const Guid& remote);

  /// The engine's handle for the host's. One that was never noted stays what it is: whether there
  /// is such an identity is for the engine to say.
  spi::IdentityHandle pair(spi::IdentityHandle local, spi::IdentityHandle remote) const;

  /// The GUID behind the host's handle of a remote; nothing for any other.
  std::optional<Guid> guid(spi::IdentityHandle of_host) const;
  /// Has the local participant met the remote one, and the host not returned it since?
  bool has_met(spi::IdentityHandle local, const Guid& remote) const;
  /// The host's handle and the GUID of each remote.
  std::vector<std::pair<spi::IdentityHandle, Guid>> all() const;

  /// The host returns a remote identity, or a local one: what has to be returned to the engine.
  std::vector<spi::IdentityHandle> take(spi::IdentityHandle identity);

  /// Has `expire` found that this local participant ended?
  bool has_ended(spi::IdentityHandle local) const;

  struct ToRevoke {
    std::vector<spi::IdentityHandle> remotes = {};  ///< the host's handles
    std::vector<spi::IdentityHandle> locals = {};
  };
  /// What the engine's `expire` found, as the host knows it. The host can remove a remote
  /// participant for all its local ones only, so one whose only fault is that a local participant
  /// ended is left to the others that have it.
  ToRevoke to_revoke(std::span<const spi::IdentityHandle> ended);

 private:
  struct Remote {
    spi::IdentityHandle of_host;
    std::map<spi::IdentityHandle, spi::IdentityHandle> pairs = {};  ///< by local identity
  };
  const Remote* find(spi::IdentityHandle handle) const;
  bool stays(const Remote& remote, spi::IdentityHandle pair) const;
  void forget_local(spi::IdentityHandle local);

  mutable std::mutex mutex_;
  std::map<Guid, Remote> remotes_;
  std::map<spi::IdentityHandle, Guid> guid_of_;  ///< of host's handles and of pairs
  std::set<spi::IdentityHandle> ended_locals_;
};

}  // namespace ddssec::cyclonedds
