// Which remote participants have sent their keys. Only then is a handshake over for the host, so
// our authentication, in another library of the process, asks for it (handshake_watch.hpp).
#pragma once

#include <atomic>
#include <chrono>
#include <mutex>
#include <unordered_map>

#include "plugins/spi/handles.hpp"

namespace ddssec::cyclonedds {

/// Of all domains of the process. Thread-safe.
class PeersWithKeys {
 public:
  static PeersWithKeys& of_process();

  /// Without memory the peer stays unknown, and is taken for one without keys.
  void met(spi::ParticipantCryptoHandle peer, spi::IdentityHandle identity) noexcept;
  void sent_keys(spi::ParticipantCryptoHandle peer);
  void left(spi::ParticipantCryptoHandle peer);
  /// A remote endpoint of the key exchange, and a message of it that was opened. Only while keys of
  /// a peer are awaited is anything noted. Without memory nothing is.
  void matched(std::int64_t endpoint, spi::ParticipantCryptoHandle peer) noexcept;
  void forget(std::int64_t endpoint);
  void heard(std::int64_t endpoint, std::chrono::nanoseconds now);
  bool awaits_keys() const noexcept { return awaited_.load(std::memory_order_relaxed) > 0; }

  bool contains(spi::IdentityHandle identity) const;
  /// 0: never.
  std::chrono::nanoseconds last_heard(spi::IdentityHandle identity) const;

 private:
  struct Peer {
    std::int64_t identity;
    bool sent_keys = false;
    std::chrono::nanoseconds last_heard{};
  };
  const Peer* find(spi::IdentityHandle identity) const;

  mutable std::mutex mutex_;
  std::unordered_map<std::int64_t, Peer> peers_;                ///< by crypto handle
  std::unordered_map<std::int64_t, std::int64_t> by_identity_;  ///< crypto handle
  std::unordered_map<std::int64_t, std::int64_t> endpoints_;    ///< crypto handle of their peer
  std::atomic<std::size_t> awaited_ = 0;                        ///< peers without keys
};

}  // namespace ddssec::cyclonedds
