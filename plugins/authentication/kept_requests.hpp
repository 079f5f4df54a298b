// Handshake requests of peers that the host has dropped before they answered. A host drops a peer
// to begin its handshake anew, after a disturbance. Stock plugins answer only the request that they
// saw first, as often as it takes. So who is met again is sent the same request, and the answer to
// it counts.
#pragma once

#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "base/ids.hpp"
#include "plugins/authentication/identity_table.hpp"

namespace ddssec::authentication {

/// Thread-safe.
class KeptRequests {
 public:
  using MonotonicTime = std::chrono::nanoseconds;
  /// Beyond that the one that was made first is forgotten: a stranger can announce any number of
  /// participants.
  static constexpr std::size_t kMost = 256;
  /// How long an ephemeral key waits for its answer.
  static constexpr MonotonicTime kLife = std::chrono::hours(1);

  /// Keeps the pair's request, if it waits for its answer. The pair is in no table any more.
  void keep(Pair& pair, MonotonicTime now);
  /// The challenge in the request that is kept.
  std::optional<spi::Challenge> challenge(spi::IdentityHandle local, const Guid& remote,
                                          MonotonicTime now);
  std::optional<PairHandshake> take(spi::IdentityHandle local, const Guid& remote);
  /// The local identity is gone.
  void forget(spi::IdentityHandle local);

 private:
  using Key = std::pair<spi::IdentityHandle, Guid>;  ///< local, remote
  struct Kept {
    spi::Challenge challenge;
    PairHandshake handshake;
  };
  void make_room(MonotonicTime now);

  std::mutex mutex_;
  std::map<Key, Kept> all_;
};

}  // namespace ddssec::authentication
