// Peers that have lost their session with us and prove it (plugins/spi/session_reset.hpp).
// Cyclone's core ignores a peer that begins a new handshake while it keeps the old session. So our
// authentication, in another library of the process, asks here and revokes the peer: the core
// forgets it and discovers it anew.
#pragma once

#include <atomic>
#include <map>
#include <mutex>

#include "plugins/spi/handles.hpp"
#include "plugins/spi/session_reset.hpp"

namespace ddssec::cyclonedds {

/// Of all domains of the process. Thread-safe.
class SessionResets {
 public:
  static SessionResets& of_process();

  /// From now on `peer` may prove with `token` that it has lost the session. Without memory it
  /// cannot, which leaves the session as it is.
  void expect(spi::ParticipantCryptoHandle peer, spi::IdentityHandle identity,
              spi::ResetToken token) noexcept;
  void forget(spi::ParticipantCryptoHandle peer);
  /// False: not the token of a session that we have.
  bool received(const spi::Reset& reset);
  /// Whether that remote participant asked for a reset since the last call.
  bool take(spi::IdentityHandle identity);

 private:
  struct Session {
    spi::ParticipantCryptoHandle peer;
    spi::IdentityHandle identity;
    spi::ResetProof proof;
    bool is_lost = false;
  };

  std::mutex mutex_;
  std::map<spi::ResetName, Session> sessions_;
  std::multimap<std::int64_t, spi::ResetName> names_;  ///< by the peer's handle
  std::atomic<std::size_t> lost_ = 0;  ///< not yet taken; `take` asks for every peer each second
};

}  // namespace ddssec::cyclonedds
