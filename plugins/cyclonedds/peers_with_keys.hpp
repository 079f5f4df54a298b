// Which remote participants have sent their keys, and were matched with all our builtin endpoints.
// Only then is a handshake over for the host, so our authentication, in another library of the
// process, asks for it (handshake_watch.hpp). The host matches builtin endpoints by an announcement
// that a stranger can forge; what the peer really has stands in the participant data that it
// signed.
#pragma once

#include <atomic>
#include <chrono>
#include <mutex>
#include <set>
#include <unordered_map>

#include "plugins/spi/handles.hpp"

namespace ddssec::cyclonedds {

/// Of all domains of the process. Thread-safe.
class PeersWithKeys {
 public:
  static PeersWithKeys& of_process();

  /// Bits of BuiltinEndpointSet_t (DDS-Security 7.4.7.1): secure discovery of participants,
  /// publications and subscriptions, secure liveliness, and the key exchange.
  static constexpr std::uint32_t kSecureEndpoints = 0x0f3f0000;

  /// Our local participant `local` met the peer, which signed that it has these builtin endpoints.
  /// Without memory the peer stays unknown, and is taken for one without keys.
  void met(spi::ParticipantCryptoHandle peer, spi::IdentityHandle identity,
           spi::ParticipantCryptoHandle local, std::uint32_t builtin_endpoints) noexcept;
  void sent_keys(spi::ParticipantCryptoHandle peer);
  void left(spi::ParticipantCryptoHandle peer);
  /// A protected builtin endpoint of ours. Without memory it is not waited for.
  void add_builtin(std::int64_t endpoint, spi::ParticipantCryptoHandle local) noexcept;
  /// The host matched `endpoint` of the peer with `own` of ours. Without memory nothing is noted.
  void matched(std::int64_t endpoint, spi::ParticipantCryptoHandle peer, std::int64_t own) noexcept;
  /// An endpoint of the peer or of ours is gone.
  void forget(std::int64_t endpoint);
  /// A message of the peer's endpoint was opened. Only while keys of a peer are awaited is anything
  /// noted.
  void heard(std::int64_t endpoint, std::chrono::nanoseconds now);
  bool awaits_keys() const noexcept { return awaited_.load(std::memory_order_relaxed) > 0; }

  bool contains(spi::IdentityHandle identity) const;
  /// Is each of our protected builtin endpoints matched? True as well for a peer that does
  /// not have all kSecureEndpoints: what it lacks is not known here.
  bool is_matched(spi::IdentityHandle identity) const;
  /// 0: never.
  std::chrono::nanoseconds last_heard(spi::IdentityHandle identity) const;

 private:
  struct Peer {
    std::int64_t identity;
    bool sent_keys = false;
    bool has_all_endpoints = false;
    std::chrono::nanoseconds last_heard{};
    std::set<std::int64_t> locals = {};        ///< that met it
    std::multiset<std::int64_t> matched = {};  ///< builtin endpoints of ours, for each of its own
  };
  struct Endpoint {
    std::int64_t peer;  ///< its crypto handle
    std::int64_t own;   ///< of ours, which it is matched with
  };
  const Peer* find(spi::IdentityHandle identity) const;

  mutable std::mutex mutex_;
  std::unordered_map<std::int64_t, Peer> peers_;                ///< by crypto handle
  std::unordered_map<std::int64_t, std::int64_t> by_identity_;  ///< crypto handle
  std::unordered_map<std::int64_t, Endpoint> endpoints_;        ///< of peers
  std::unordered_map<std::int64_t, std::int64_t> builtin_;      ///< ours: their local participant
  std::atomic<std::size_t> awaited_ = 0;                        ///< peers without keys
};

}  // namespace ddssec::cyclonedds
