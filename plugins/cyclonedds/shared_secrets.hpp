// The shared secrets that were handed to the host as pointers, and how long they live.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "plugins/cyclonedds/abi.hpp"
#include "plugins/spi/handles.hpp"
#include "plugins/spi/shared_secret.hpp"

namespace ddssec::cyclonedds {

/// Cyclone's core never returns a shared secret or a handshake, and its cryptography plugin reads
/// through the pointer as long as the remote participant is there: a secret lives until one of its
/// two identities is returned. Thread-safe.
class SharedSecrets {
 public:
  /// Most handshakes of a pair remembered that have no secret yet; the oldest is dropped. Any
  /// sender can make us answer a request, only the peer can finish.
  static constexpr std::size_t kMostUnfinishedPerPair = 8;

  /// Remembers whose handshake it is.
  void note(spi::HandshakeHandle handshake, spi::IdentityHandle initiator,
            spi::IdentityHandle replier);
  /// The pointer for that handshake, the same each time. Error: foreign_shared_secret for a
  /// handshake not noted.
  Result<DDS_Security_SharedSecretHandle> hand_out(spi::HandshakeHandle handshake,
                                                   const spi::SharedSecret& secret);
  /// The two identities of a handshake, initiator first; nothing for one not noted.
  std::optional<std::pair<spi::IdentityHandle, spi::IdentityHandle>> pair_of(
      spi::HandshakeHandle handshake) const;
  /// Wipes and frees the secrets of this identity's handshakes.
  void drop(spi::IdentityHandle identity);

 private:
  /// The layout together with the octets it points to; wiped when it dies.
  struct Block {
    explicit Block(const spi::SharedSecret& secret);
    ~Block();
    Block(const Block&) = delete;
    Block& operator=(const Block&) = delete;

    ExtendedSharedSecret content{};
  };
  struct Entry {
    spi::HandshakeHandle handshake;
    std::unique_ptr<Block> block;
  };
  using Pair = std::pair<spi::IdentityHandle, spi::IdentityHandle>;

  void forget_oldest_unfinished(std::vector<Entry>& entries);

  mutable std::mutex mutex_;
  std::map<Pair, std::vector<Entry>> entries_;  ///< of a pair: in the order they were noted
  std::map<spi::HandshakeHandle, Pair> pair_of_;
};

}  // namespace ddssec::cyclonedds
