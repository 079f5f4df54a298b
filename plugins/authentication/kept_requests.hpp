// What we sent to peers that the host has dropped before their handshake ended. A host drops a peer
// to begin its handshake anew, after a disturbance. Stock plugins answer only the request that they
// saw first, as often as it takes, and accept only a reply with the challenge that we announced
// first. So a peer that is met again is sent the same request, and the answer to it counts; or it
// hears the same challenge, with a new key.
#pragma once

#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "base/clock.hpp"
#include "base/ids.hpp"
#include "plugins/authentication/identity_table.hpp"

namespace ddssec::authentication {

/// Thread-safe.
class KeptRequests {
 public:
  using MonotonicTime = std::chrono::nanoseconds;
  /// Beyond that one gives way by chance: a stranger can announce any number of participants, but
  /// does not choose whose request they push out.
  static constexpr std::size_t kMost = 512;
  /// How long an ephemeral key waits for its answer, and a challenge to be met again.
  static constexpr MonotonicTime kLife = std::chrono::hours(1);

  explicit KeptRequests(Random& random) : random_(random) {}

  /// Keeps the pair's challenge, if no handshake ended, and a request that waits for its answer.
  /// The pair is in no table any more.
  void keep(Pair& pair, MonotonicTime now);
  /// The challenge that is kept.
  std::optional<spi::Challenge> challenge(spi::IdentityHandle local, const Guid& remote,
                                          MonotonicTime now);
  /// Forgets what is kept of the pair: its request, if there was one.
  std::optional<PairHandshake> take(spi::IdentityHandle local, const Guid& remote);
  /// The local identity is gone.
  void forget(spi::IdentityHandle local);

 private:
  using Key = std::pair<spi::IdentityHandle, Guid>;  ///< local, remote
  struct Kept {
    spi::Challenge challenge;
    MonotonicTime since;
    std::optional<PairHandshake> request = {};
  };
  void make_room(MonotonicTime now);

  Random& random_;
  std::mutex mutex_;
  std::map<Key, Kept> all_;
};

}  // namespace ddssec::authentication
