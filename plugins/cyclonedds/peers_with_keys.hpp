// Knows, for each peer, whether its keys have arrived and its builtin endpoints are matched.
// Authentication asks this (handshake_watch.hpp) to see whether a handshake is over for the host.
// The host matches builtin endpoints by an announcement, which an attacker can forge. The endpoints
// that the peer really has are in the participant data that it signed.
#pragma once

#include <atomic>
#include <chrono>
#include <mutex>
#include <set>
#include <unordered_map>

#include "plugins/spi/handles.hpp"

namespace ddssec::cyclonedds {

/// The peers of all domains of the process. Thread-safe.
class PeersWithKeys {
 public:
  static PeersWithKeys& of_process();

  /// Bits of BuiltinEndpointSet_t (DDS-Security 1.2, clause 7.5.1.4): secure discovery of
  /// participants, publications and subscriptions, secure liveliness, and the key exchange.
  static constexpr std::uint32_t kSecureEndpoints = 0x0f3f0000;

  /// Adds a local participant. If memory runs out, no peer counts as one that sent it keys.
  void add_local(spi::ParticipantCryptoHandle local, spi::IdentityHandle identity) noexcept;
  /// Notes that the local participant `local` discovered the peer, which signed that it has these
  /// builtin endpoints. If memory runs out, nothing is recorded: a peer that was unknown stays
  /// unknown, and counts as one without keys. The host's own registration of the peer does not
  /// depend on this.
  void note_discovered(spi::ParticipantCryptoHandle peer, spi::IdentityHandle identity,
                       spi::ParticipantCryptoHandle local,
                       std::uint32_t builtin_endpoints) noexcept;
  /// Notes that the peer sent keys. If memory runs out, has_sent_keys() is true, but the keys count
  /// for no local participant.
  void note_keys_sent(spi::ParticipantCryptoHandle peer,
                      spi::ParticipantCryptoHandle local) noexcept;
  /// Forgets a remote participant, or a local one.
  void note_left(spi::ParticipantCryptoHandle participant);
  /// Adds a protected local builtin endpoint. If memory runs out, it is not waited for.
  void add_builtin(std::int64_t endpoint, spi::ParticipantCryptoHandle local) noexcept;
  /// Notes that the host matched the peer's `endpoint` with the local endpoint `own`. If memory
  /// runs out, nothing is recorded.
  void note_matched(std::int64_t endpoint, spi::ParticipantCryptoHandle peer,
                    std::int64_t own) noexcept;
  /// Forgets a local or remote endpoint that was removed.
  void forget(std::int64_t endpoint);
  /// Notes that a message of the peer's endpoint was decrypted. It is recorded only while
  /// awaits_keys() is true; a caller on a hot path tests that first, without the lock.
  void note_heard(std::int64_t endpoint, std::chrono::nanoseconds now);
  /// True while some peer has not sent its keys.
  bool awaits_keys() const noexcept { return awaited_.load(std::memory_order_relaxed) > 0; }

  /// True if the peer with this identity is known and has sent keys for some local participant.
  bool has_sent_keys(spi::IdentityHandle identity) const;
  /// True if the peer's keys have arrived for the local participant with the identity `local`.
  bool has_sent_keys(spi::IdentityHandle identity, spi::IdentityHandle local) const;
  /// The same, by the handles that Cryptography has given to both.
  bool has_sent_keys(spi::ParticipantCryptoHandle peer, spi::ParticipantCryptoHandle local) const;
  /// True if each protected local builtin endpoint is matched. Also true for a peer that does not
  /// have all kSecureEndpoints, because it is not known here which ones it lacks.
  bool is_matched(spi::IdentityHandle identity) const;
  /// Returns the time when the peer was last heard, by the monotonic clock; 0 for never.
  std::chrono::nanoseconds last_heard(spi::IdentityHandle identity) const;

 private:
  struct Peer {
    std::int64_t identity;
    bool has_sent_keys = false;
    bool has_all_endpoints = false;
    std::chrono::nanoseconds last_heard{};
    std::set<std::int64_t> locals = {};     ///< local participants that discovered it
    std::set<std::int64_t> with_keys = {};  ///< those for which it sent keys
    /// The matched local builtin endpoints, one entry for each endpoint of the peer.
    std::multiset<std::int64_t> matched = {};
  };
  struct Endpoint {
    std::int64_t peer;  ///< its crypto handle
    std::int64_t own;   ///< the local endpoint that it is matched with
  };
  const Peer* find(spi::IdentityHandle identity) const;

  mutable std::mutex mutex_;
  std::unordered_map<std::int64_t, Peer> peers_;                ///< by crypto handle
  std::unordered_map<std::int64_t, std::int64_t> by_identity_;  ///< crypto handle
  std::unordered_map<std::int64_t, std::int64_t> local_of_;     ///< crypto handle, by identity
  std::unordered_map<std::int64_t, Endpoint> endpoints_;        ///< endpoints of peers
  /// The participants of local builtin endpoints.
  std::unordered_map<std::int64_t, std::int64_t> builtin_;
  std::atomic<std::size_t> awaited_ = 0;  ///< peers without keys
};

}  // namespace ddssec::cyclonedds
