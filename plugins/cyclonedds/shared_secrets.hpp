// The shared secrets that the host holds as pointers, and their lifetime.
#pragma once

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

/// Cyclone's core never returns a shared secret or a handshake. Its cryptography plugin reads
/// through the pointer as long as the remote participant exists. So a secret lives until one of its
/// two identities is returned. Thread-safe.
class SharedSecrets {
 public:
  /// The largest number of remembered handshakes of a pair without a secret; the oldest is dropped.
  /// Any sender can cause an answer to a request, but only the peer can finish a handshake.
  static constexpr std::size_t kMaxUnfinishedPerPair = 8;

  /// Remembers the two identities of a handshake.
  void note(spi::HandshakeHandle handshake, spi::IdentityHandle initiator,
            spi::IdentityHandle replier);
  /// Returns the pointer for that handshake, the same each time. Error: foreign_shared_secret for
  /// an unknown handshake.
  Result<DDS_Security_SharedSecretHandle> pointer_for(spi::HandshakeHandle handshake,
                                                      const spi::SharedSecret& secret);
  /// Returns the two identities of a handshake, initiator first; empty for an unknown handshake.
  std::optional<std::pair<spi::IdentityHandle, spi::IdentityHandle>> pair_of(
      spi::HandshakeHandle handshake) const;
  /// Wipes and frees the secrets of this identity's handshakes.
  void drop(spi::IdentityHandle identity);

 private:
  /// The layout together with the octets that it points to; wiped at destruction.
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
  using HandlePair = std::pair<spi::IdentityHandle, spi::IdentityHandle>;

  void forget_oldest_unfinished(std::vector<Entry>& entries);

  mutable std::mutex mutex_;
  std::map<HandlePair, std::vector<Entry>> entries_;  ///< for each pair in the order of `note`
  std::map<spi::HandshakeHandle, HandlePair> pair_of_;
};

}  // namespace ddssec::cyclonedds
