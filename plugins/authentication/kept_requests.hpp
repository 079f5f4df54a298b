// Handshake requests and challenges sent to peers that the host dropped before their handshake
// ended. A host drops a peer to restart its handshake after a disturbance.
//
// Stock plugins answer only the first request that they saw, each time it comes. They accept only a
// reply with the challenge that was announced first. A peer that appears again is therefore sent
// the same request, and the answer to it counts. A reply that was sent may still reach the peer,
// which then keeps to it. The same request is therefore answered with the same challenge and key.
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

/// The stored requests and challenges. Thread-safe.
class KeptRequests {
 public:
  using MonotonicTime = std::chrono::nanoseconds;
  /// The largest number of entries. If it is exceeded, a random entry is dropped: an attacker can
  /// announce any number of participants, but cannot choose whose entry they displace.
  static constexpr std::size_t kMax = 512;
  /// How long an ephemeral key waits for its answer, and a challenge for its peer.
  static constexpr MonotonicTime kLife = std::chrono::hours(1);

  explicit KeptRequests(Random& random) : random_(random) {}

  /// The largest number of reply keys of an entry. The newest ones are kept.
  static constexpr std::size_t kMaxReplyKeys = 4;

  /// Stores the pair's challenge, a request that waits for its answer, and the keys of replies,
  /// unless a handshake of the pair was established. The pair must already be removed from all
  /// tables. `now` is Clock::monotonic.
  void keep(IdentityPair& pair, MonotonicTime now);
  /// Returns the stored challenge; empty if there is none or it is older than kLife.
  std::optional<spi::Challenge> challenge(spi::IdentityHandle local, const Guid& remote,
                                          MonotonicTime now);
  struct KeptHandshake {
    std::optional<PairHandshake> request = {};
    std::vector<ReplyKey> reply_keys = {};
  };
  /// Removes the pair's entry and returns its content.
  KeptHandshake take(spi::IdentityHandle local, const Guid& remote);
  /// Removes all entries of a local identity.
  void forget(spi::IdentityHandle local);

 private:
  using Key = std::pair<spi::IdentityHandle, Guid>;  ///< local, remote
  struct Entry {
    spi::Challenge challenge;
    MonotonicTime since;
    KeptHandshake held = {};
  };
  static std::vector<ReplyKey> reply_keys(IdentityPair& pair);
  void make_room(MonotonicTime now);

  Random& random_;
  std::mutex mutex_;
  std::map<Key, Entry> all_;
};

}  // namespace ddssec::authentication
