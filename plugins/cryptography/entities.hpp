// Participants and endpoints, local and remote, as the registry stores them.
//
// Ownership and lifetime: the registry owns entities, and entities own their keys. One thread at a
// time makes changes, under the mutex of CryptographyState. The message path follows pointers under
// a ReadGuard without any lock. It follows only two kinds of data. Some never change during an
// entity's life (handle, kind, protection, pointers to the parents). The others are published:
// local keys, key material from tokens, pairs and routes are replaced as a whole, and the former
// object is destroyed after its last reader. An entity is unlinked from all tables and from the
// registry before it is retired. Children are retired with their parents, so a pointer to a parent
// never dangles within a guard.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <pthread.h>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "plugins/cryptography/fragment_walks.hpp"
#include "plugins/cryptography/fragmented_tokens.hpp"
#include "plugins/cryptography/key_life.hpp"
#include "plugins/cryptography/match_shares.hpp"
#include "plugins/cryptography/payload_positions.hpp"
#include "plugins/cryptography/receive_key.hpp"
#include "plugins/cryptography/receiver_places.hpp"
#include "plugins/cryptography/registry.hpp"
#include "plugins/cryptography/routes.hpp"
#include "plugins/cryptography/send_key.hpp"
#include "plugins/cryptography/subject_id.hpp"
#include "plugins/spi/attributes.hpp"
#include "plugins/spi/cryptography.hpp"

namespace ddssec::cryptography {

/// The keys of one revision of a remote entity. A pointer is null if no key came, or if this level
/// needs none.
struct LevelKeys {
  std::shared_ptr<ReceiveKey> submessage;  ///< for submessages; of a participant: for RTPS messages
  std::shared_ptr<ReceiveKey> payload;
};
using KeyLevel = std::shared_ptr<ReceiveKey> LevelKeys::*;

/// The keys of a remote entity from its tokens: the newest, and former revisions that stay valid
/// for a while (key_revision.hpp).
struct RemoteKeys final : RetirableObject, LevelKeys {
  struct FormerKeys : LevelKeys {
    std::chrono::nanoseconds until;  ///< by the monotonic clock
  };
  std::vector<FormerKeys> former;  ///< newest first
  /// The endpoint that owns the keys; zero if it is not known (key_owner.hpp).
  EntityId owner = {};
};

/// A participant of this process, with the key of its RTPS messages.
struct LocalParticipantCrypto final : CryptoEntity {
  LocalParticipantCrypto() : CryptoEntity(EntityKind::local_participant) {}
  spi::ProtectionKind rtps = spi::ProtectionKind::none;
  Cipher cipher = Cipher::aes256_gcm;           ///< cipher of messages and builtin endpoints
  Cipher endpoint_cipher = Cipher::aes256_gcm;  ///< cipher of the application's endpoints
  spi::CipherMask allowed_ciphers = spi::kAllCiphers;
  PublishedPointer<SendKey> key;  ///< nullptr if RTPS messages are not protected
  std::atomic<bool> is_cut_off = false;
  bool protects_discovery = false;
  ClosedDiscovery closed_discovery = {};
  bool trusts_type_information = false;  ///< the host receives the type information of peers
  bool revises_keys = false;
  bool is_revising = false;  ///< new keys exist and are not in use yet
  spi::KeyRevision revision = 0;
  KeyLife life;
  std::unique_ptr<SendKey> next_key = {};
  std::unordered_set<std::int64_t> endpoints;
  std::unordered_set<std::int64_t> matched;  ///< remote participants
  /// The places of the receivers of RTPS messages.
  ReceiverPlaces receivers{ReceiverPlaces::kMaxOfEach, "participants"};
};

/// Success unless the participant was cut off. Error: identity_ended.
inline Status check_not_cut_off(const LocalParticipantCrypto& participant) {
  if (!participant.is_cut_off.load(std::memory_order_relaxed)) [[likely]]
    return {};
  return fail(Code::identity_ended);
}

/// The participants in whose names messages of a peer spoke, to report each once. Thread-safe.
class NamesSpoken {
 public:
  static constexpr std::size_t kMax = 8;
  /// True if the name is new and fewer than kMax are recorded.
  bool note(const GuidPrefix& name) {
    const std::lock_guard lock(mutex_);
    const bool is_new = std::find(names_.begin(), names_.end(), name) == names_.end();
    if (!is_new || names_.size() >= kMax) return false;
    names_.push_back(name);
    return true;
  }

 private:
  std::mutex mutex_;
  std::vector<GuidPrefix> names_;
};

/// The state that one local and one remote participant share.
struct ParticipantPair final : RetirableObject {
  explicit ParticipantPair(const LocalParticipantCrypto& local_participant)
      : local(local_participant) {}
  const LocalParticipantCrypto& local;
  std::uint64_t number = 0;  ///< number of the key exchange; unique
  spi::CipherMask peer_ciphers = spi::kStandardCiphers;
  std::optional<GuidPrefix> peer_prefix = {};  ///< empty with another vendor's authentication
  /// The prefix of the local participant; empty with another vendor's authentication.
  std::optional<GuidPrefix> own_prefix = {};
  /// The permissions of the remote participant; guarded by the mutex of CryptographyState.
  spi::PermissionsHandle permissions = {};
  /// Local key for the remote participant; nullptr if it is not needed.
  std::unique_ptr<ReceiverKey> receiver_key;
  /// Subject whose place it takes among the local participant's receivers.
  std::optional<SubjectId> place_subject = {};
  std::unique_ptr<SendKey> key_exchange_send;
  std::unique_ptr<ReceiveKey> key_exchange_receive;
  /// True once the local volatile reader has sent anything to the peer (kept_tokens.hpp).
  std::atomic<bool> has_reader_spoken = false;
  PublishedPointer<RemoteKeys> remote_keys;
  NamesSpoken names_spoken;            ///< names of other authenticated peers
  FragmentedTokens fragmented_tokens;  ///< key token messages that went to the peer in fragments

  /// True if the peer uses ddssec: of all products, only ddssec announces ChaCha20-Poly1305.
  bool peer_uses_ddssec() const { return (peer_ciphers & spi::kChaCha20Poly1305Bit) != 0; }
};

/// Maps a local participant's handle to its pair. There are as many rows as local participants in
/// the process.
struct PairTable final : RetirableObject {
  struct Row {
    std::int64_t local;
    ParticipantPair* pair;
  };
  std::vector<Row> rows;
};

/// A remote participant. It is one object for all local participants that use its handle.
struct RemoteParticipantCrypto final : CryptoEntity {
  explicit RemoteParticipantCrypto(const Registry& registry)
      : CryptoEntity(EntityKind::remote_participant), routes(registry) {}
  std::int64_t identity = 0;
  std::unordered_set<std::int64_t> endpoints;
  std::unordered_map<std::int64_t, std::unique_ptr<ParticipantPair>>
      pairs;  ///< by local participant
  PublishedPointer<PairTable> pair_table;
  Routes routes;                            ///< routes to its endpoints that protect submessages
  PayloadPositions payload_positions = {};  ///< positions of its writers that protect payloads only
  mutable PeerDiscovery discovery = {};

  /// Returns the pair with that local participant, or nullptr. Call it under a ReadGuard.
  ParticipantPair* pair(std::int64_t local) const {
    const auto* const table = pair_table.read();
    if (table == nullptr) return nullptr;
    for (const auto& row : table->rows)
      if (row.local == local) return row.pair;
    return nullptr;
  }
};

/// A local reader's submessage key for one remote participant.
///
/// Submessages under this key can be decrypted by that participant only. This is needed because the
/// destination of a submessage is not protected. With a common key, an ACKNACK for one writer would
/// acknowledge the samples of another with the same entity id. With origin authentication, the
/// receiver's own MAC prevents this, and the reader has one key.
struct PeerKey {
  PublishedPointer<SendKey> key;
  std::unique_ptr<SendKey> next = {};
  /// Number of the participant's writers that are matched with the reader.
  std::size_t writers = 0;
};

/// A local datawriter or datareader.
struct LocalEndpointCrypto final : CryptoEntity {
  LocalEndpointCrypto(EntityKind kind, LocalParticipantCrypto& parent)
      : CryptoEntity(kind),
        participant(parent),
        receivers(spi::is_origin_authenticated(parent.rtps) ? ReceiverPlaces::kMaxOfEach
                                                            : ReceiverPlaces::kMax) {}
  LocalParticipantCrypto& participant;
  spi::ProtectionKind submessage = spi::ProtectionKind::none;
  spi::ProtectionKind payload = spi::ProtectionKind::none;
  bool is_builtin = false;   ///< according to access control
  bool is_volatile = false;  ///< ParticipantVolatileMessageSecure: keys of the key exchange
  bool is_discovery_protected = false;  ///< true if its announcements come under a key
  /// The thread that made it. The host matches a new endpoint with all known ones in that thread.
  const pthread_t creating_thread = pthread_self();
  MonotonicTime created_at{};
  /// Decides which peers get keys; nullptr if there is no check here.
  std::shared_ptr<const spi::MatchGate> gate = {};
  Cipher cipher = Cipher::aes256_gcm;
  PublishedPointer<SendKey> submessage_key;  ///< nullptr if it has peer keys
  PublishedPointer<SendKey> payload_key;
  std::unordered_map<std::int64_t, std::shared_ptr<PeerKey>> peer_keys;  ///< by participant
  std::unique_ptr<SendKey> next_submessage_key = {}, next_payload_key = {};
  /// A reader's key that is sent but never used, because only payloads are protected.
  std::optional<KeyMaterial> unused_reader_key;
  std::unordered_set<std::int64_t> matched;  ///< remote endpoints
  ReceiverPlaces receivers;                  ///< a writer's receivers that each need a MAC
  MatchShares matches;

  bool has_peer_keys() const {
    return kind() == EntityKind::local_reader && !is_volatile && is_protected(submessage) &&
           !is_origin_authenticated(submessage);
  }
  bool sends_protected() const {
    return has_peer_keys() || submessage_key.read() != nullptr || payload_key.read() != nullptr;
  }
  bool has_tokens() const {
    return !is_volatile && (is_protected(submessage) || is_protected(payload));
  }
};

/// A remote datawriter or datareader, as matched with one local endpoint.
struct RemoteEndpointCrypto final : CryptoEntity {
  RemoteEndpointCrypto(EntityKind kind, LocalEndpointCrypto& local_endpoint,
                       RemoteParticipantCrypto& parent)
      : CryptoEntity(kind), local(local_endpoint), participant(parent) {}
  LocalEndpointCrypto& local;
  RemoteParticipantCrypto& participant;
  std::unique_ptr<ReceiverKey> receiver_key;  ///< local key for it; nullptr if not needed
  std::shared_ptr<PeerKey> peer_key = {};  ///< local key for its participant; nullptr if not needed
  PublishedPointer<RemoteKeys> remote_keys;
  std::atomic<std::uint64_t> route = 0;  ///< number of its only valid route; 0 if there is none
  /// Subject whose place it takes among the local writer's receivers.
  std::optional<SubjectId> place_subject = {};
  /// Subject for which the local endpoint counts the match; empty if it is not counted.
  std::optional<SubjectId> match_subject = {};
  bool is_counted_by_discovery_work = false;  ///< DiscoveryWork counts the match
};

}  // namespace ddssec::cryptography
