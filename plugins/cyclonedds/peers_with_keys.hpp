// Which remote participants have sent their keys. Only then is a handshake over for the host, so
// our authentication, in another library of the process, asks for it (handshake_watch.hpp).
#pragma once

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

  bool contains(spi::IdentityHandle identity) const;

 private:
  struct Peer {
    std::int64_t identity;
    bool sent_keys = false;
  };
  mutable std::mutex mutex_;
  std::unordered_map<std::int64_t, Peer> peers_;                ///< by crypto handle
  std::unordered_map<std::int64_t, std::int64_t> by_identity_;  ///< crypto handle
};

}  // namespace ddssec::cyclonedds
