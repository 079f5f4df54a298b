// Maps the host's single handle of a remote participant to the plugin's handles, one for each pair.
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

/// Cyclone's core has one identity handle for a remote participant, however many local participants
/// discovered it. It keeps the last handle that it got, asserts that all are the same and returns
/// it once. The plugin has one handle for each pair of a local and a remote participant. All calls
/// in between also name the local participant or a handshake. Thread-safe.
class RemoteIdentities {
 public:
  /// Remembers the plugin's handle of a pair and returns the host's handle for the remote
  /// participant: that of the first pair, as long as the host keeps it.
  spi::IdentityHandle note(spi::IdentityHandle local, const Guid& remote, spi::IdentityHandle pair);

  /// Returns the host's handle for a remote participant that the plugin did not admit. It is the
  /// one that the host has, or a new one that is unique in the process and has no identity yet.
  spi::IdentityHandle note_refused(const Guid& remote);

  /// Returns the plugin's handle for the host's. An unknown handle is returned unchanged; the
  /// plugin decides whether there is such an identity.
  spi::IdentityHandle pair(spi::IdentityHandle local, spi::IdentityHandle remote) const;

  /// Returns the GUID for the host's handle of a remote participant; empty for any other handle.
  std::optional<Guid> guid(spi::IdentityHandle of_host) const;
  /// True if the local participant has discovered the remote one, and the host has not returned it
  /// since.
  bool has_discovered(spi::IdentityHandle local, const Guid& remote) const;
  /// Returns the host's handle and the GUID of each remote participant.
  std::vector<std::pair<spi::IdentityHandle, Guid>> all() const;

  /// Removes a remote or a local identity that the host returns. Returns the handles to return to
  /// the plugin.
  std::vector<spi::IdentityHandle> take(spi::IdentityHandle identity);

  /// True if `poll` has reported this local participant.
  bool has_ended(spi::IdentityHandle local) const;

  struct HandlesToRevoke {
    std::vector<spi::IdentityHandle> remotes = {};  ///< the host's handles
    std::vector<spi::IdentityHandle> locals = {};
  };
  /// Converts the result of the plugin's `poll` to the host's handles. The host can remove a
  /// remote participant only for all local ones. So a remote participant that is reported only
  /// because a local participant ended stays for the others that have discovered it.
  HandlesToRevoke to_revoke(std::span<const spi::IdentityHandle> ended);

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
  std::map<spi::IdentityHandle, Guid> guid_of_;  ///< GUIDs of the host's handles and of pairs
  std::set<spi::IdentityHandle> ended_locals_;
};

}  // namespace ddssec::cyclonedds
