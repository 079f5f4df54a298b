// Peers that prove that they have lost their session (plugins/spi/session_reset.hpp). Cyclone's
// core ignores a peer that begins a new handshake while it keeps the old session. So
// libddssec_authentication asks here and revokes the peer: the core forgets it and discovers it
// again.
#pragma once

#include <atomic>
#include <map>
#include <mutex>

#include "plugins/cyclonedds/abi.hpp"
#include "plugins/cyclonedds/peers_with_keys.hpp"
#include "plugins/spi/handles.hpp"
#include "plugins/spi/session_reset.hpp"

namespace ddssec::cyclonedds {

/// The sessions of all domains of the process. Thread-safe.
class SessionResets {
 public:
  static SessionResets& of_process();

  /// A remote and a local participant.
  struct ResetPair {
    spi::ParticipantCryptoHandle peer;
    spi::ParticipantCryptoHandle local;
  };
  /// Notes that the peer can prove with `token` that it has lost the session. If memory runs out it
  /// cannot, and the session stays as it is.
  void expect(ResetPair pair, spi::IdentityHandle identity, spi::ResetToken token) noexcept;
  /// Forgets a remote participant, or a local one. A peer that hears the end of a local participant
  /// loses only the session with it.
  void forget(spi::ParticipantCryptoHandle participant);
  /// Checks a received reset. False if it is not the token of an existing session.
  bool note_reset(const spi::Reset& reset);
  /// Returns whether that remote participant has requested a reset since the last call. `peers` has
  /// those whose keys have arrived.
  SessionReset take(spi::IdentityHandle identity, const PeersWithKeys& peers);

 private:
  struct Session {
    ResetPair pair;
    spi::IdentityHandle identity;
    spi::ResetProof proof;
    bool is_lost = false;
  };

  std::mutex mutex_;
  std::map<spi::ResetName, Session> sessions_;
  /// The number of lost sessions that were not taken yet; `take` is called for every peer each
  /// second.
  std::atomic<std::size_t> lost_ = 0;
};

}  // namespace ddssec::cyclonedds
