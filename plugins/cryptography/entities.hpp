// Participants and endpoints, local and remote, as the registry holds them.
//
// Ownership and life: the registry owns entities, entities own their keys. All changes are made by
// one thread at a time, under Engine's mutex. The message path follows pointers under a ReadGuard
// without any lock. What it may follow either never changes during an entity's life (handle, kind,
// protection, the pointers up to the parents) or is Published: own keys, key material that tokens
// bring, pairs and routes are replaced as a whole, and the former object dies after its last
// reader. An entity is unlinked from all tables and from the registry before it is retired, and
// children are retired with their parents, so that a pointer up never dangles within a guard.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "plugins/cryptography/fragment_walks.hpp"
#include "plugins/cryptography/key_life.hpp"
#include "plugins/cryptography/key_owner.hpp"
#include "plugins/cryptography/payload_positions.hpp"
#include "plugins/cryptography/receive_key.hpp"
#include "plugins/cryptography/receiver_places.hpp"
#include "plugins/cryptography/registry.hpp"
#include "plugins/cryptography/routes.hpp"
#include "plugins/cryptography/send_key.hpp"
#include "plugins/spi/attributes.hpp"
#include "plugins/spi/cryptography.hpp"

namespace ddssec::cryptography {

/// Keys of one revision of a remote entity. Null: none came, or none is due at that level.
struct LevelKeys {
  std::shared_ptr<ReceiveKey> submessage;  ///< or, for a participant, of RTPS messages
  std::shared_ptr<ReceiveKey> payload;
};
using KeyLevel = std::shared_ptr<ReceiveKey> LevelKeys::*;

/// The keys of a remote entity, as its tokens said: the newest, and former revisions that still
/// count for a while (key_revision.hpp).
struct RemoteKeys final : Retirable, LevelKeys {
  struct Former : LevelKeys {
    std::chrono::nanoseconds until;  ///< by the monotonic clock
  };
  std::vector<Former> former;  ///< newest first
  EntityId owner = {};         ///< of an endpoint's keys; zero: not known (key_owner.hpp)
};

struct LocalParticipant final : Entity {
  LocalParticipant() : Entity(EntityKind::local_participant) {}
  spi::ProtectionKind rtps = spi::ProtectionKind::none;
  Cipher cipher = Cipher::aes256_gcm;           ///< of messages and builtin endpoints
  Cipher endpoint_cipher = Cipher::aes256_gcm;  ///< of the application's endpoints
  spi::CipherMask allowed_ciphers = spi::kAllCiphers;
  Published<SendKey> key;  ///< null if RTPS messages are not protected
  std::atomic<bool> is_cut_off = false;
  bool trusts_type_information = false;  ///< the host gets that of peers
  bool revises_keys = false;
  bool is_revising = false;  ///< the next keys are not in use yet
  spi::KeyRevision revision = 0;
  KeyLife life;
  std::unique_ptr<SendKey> next_key = {};
  std::unordered_set<std::int64_t> endpoints;
  std::unordered_set<std::int64_t> matched;                               ///< remote participants
  ReceiverPlaces receivers{ReceiverPlaces::kMostOfEach, "participants"};  ///< of RTPS messages
};

/// Error: identity_ended.
inline Status check_not_cut_off(const LocalParticipant& participant) {
  if (!participant.is_cut_off.load(std::memory_order_relaxed)) [[likely]]
    return {};
  return fail(Code::identity_ended);
}

/// In whose names the messages of a peer spoke, to tell each once. Thread-safe.
class NamesSpoken {
 public:
  static constexpr std::size_t kMax = 8;
  /// True if it is new, and not one too many.
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

/// What one local and one remote participant have with each other.
struct Pair final : Retirable {
  explicit Pair(const LocalParticipant& local_participant) : local(local_participant) {}
  const LocalParticipant& local;
  std::uint64_t number = 0;  ///< of the key exchange: no two have one
  spi::CipherMask peer_ciphers = spi::kStandardCiphers;
  std::optional<GuidPrefix> peer_prefix = {};  ///< nothing: another vendor's authentication
  std::optional<GuidPrefix> own_prefix = {};   ///< the local participant's; nothing: the same
  spi::PermissionsHandle permissions = {};     ///< the remote's; under Engine's mutex
  std::unique_ptr<ReceiverKey> receiver_key;   ///< ours towards the remote; null without need
  std::optional<std::uint64_t> place = {};     ///< whose place among the local one's receivers
  std::unique_ptr<SendKey> key_exchange_send;
  std::unique_ptr<ReceiveKey> key_exchange_receive;
  Published<RemoteKeys> remote_keys;
  NamesSpoken names_spoken;  ///< of other authenticated peers

  /// Of the products that may be at the other end only ours announces ChaCha20-Poly1305.
  bool is_with_ours() const { return (peer_ciphers & spi::kChaCha20Poly1305Bit) != 0; }
};

/// Local participant's handle -> pair. As many rows as local participants of one process.
struct PairTable final : Retirable {
  struct Row {
    std::int64_t local;
    Pair* pair;
  };
  std::vector<Row> rows;
};

struct RemoteParticipant final : Entity {
  explicit RemoteParticipant(const Registry& registry)
      : Entity(EntityKind::remote_participant), routes(registry) {}
  std::int64_t identity = 0;
  std::unordered_set<std::int64_t> endpoints;
  std::unordered_map<std::int64_t, std::unique_ptr<Pair>> pairs;  ///< by local participant
  Published<PairTable> pair_table;
  Routes routes;                            ///< of its endpoints that protect submessages
  PayloadPositions payload_positions = {};  ///< of its writers that protect payloads alone
  mutable PeerDiscovery discovery = {};

  /// Under a ReadGuard: what it has with that local participant, or nullptr.
  Pair* pair(std::int64_t local) const {
    const auto* const table = pair_table.read();
    if (table == nullptr) return nullptr;
    for (const auto& row : table->rows)
      if (row.local == local) return row.pair;
    return nullptr;
  }
};

/// A local reader's submessage key towards one remote participant. What the reader says to that
/// participant's writers opens nowhere else: the destination of a submessage is not protected with
/// it, and an ACKNACK for one writer would acknowledge the samples of another that has the same
/// entity id. With origin authentication the receiver's own MAC does that, and the reader has one
/// key.
struct PeerKey {
  Published<SendKey> key;
  std::unique_ptr<SendKey> next = {};
  std::size_t writers = 0;  ///< of the participant that are matched with the reader
};

/// A local datawriter or datareader.
struct LocalEndpoint final : Entity {
  LocalEndpoint(EntityKind kind, LocalParticipant& parent)
      : Entity(kind),
        participant(parent),
        receivers(spi::is_origin_authenticated(parent.rtps) ? ReceiverPlaces::kMostOfEach
                                                            : ReceiverPlaces::kMost) {}
  LocalParticipant& participant;
  spi::ProtectionKind submessage = spi::ProtectionKind::none;
  spi::ProtectionKind payload = spi::ProtectionKind::none;
  bool is_builtin = false;   ///< as access control says
  bool is_volatile = false;  ///< ParticipantVolatileMessageSecure: keys of the key exchange
  std::shared_ptr<const spi::MatchGate> gate = {};  ///< who gets keys; null: not asked here
  Cipher cipher = Cipher::aes256_gcm;
  Published<SendKey> submessage_key;  ///< null if it has peer keys
  Published<SendKey> payload_key;
  std::unordered_map<std::int64_t, std::shared_ptr<PeerKey>> peer_keys;  ///< by participant
  std::unique_ptr<SendKey> next_submessage_key = {}, next_payload_key = {};
  /// A reader's key that is only ever sent, where only payloads are protected.
  std::optional<KeyMaterial> token_only;
  std::unordered_set<std::int64_t> matched;  ///< remote endpoints
  ReceiverPlaces receivers;                  ///< a writer's that need a MAC each

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
struct RemoteEndpoint final : Entity {
  RemoteEndpoint(EntityKind kind, LocalEndpoint& local_endpoint, RemoteParticipant& parent)
      : Entity(kind), local(local_endpoint), participant(parent) {}
  LocalEndpoint& local;
  RemoteParticipant& participant;
  std::unique_ptr<ReceiverKey> receiver_key;  ///< ours towards it; null without need
  std::shared_ptr<PeerKey> peer_key = {};     ///< ours towards its participant; null without need
  Published<RemoteKeys> remote_keys;
  std::atomic<std::uint64_t> route = 0;     ///< the number of its only route that counts; 0: none
  std::optional<std::uint64_t> place = {};  ///< whose place among the local writer's receivers
};

}  // namespace ddssec::cryptography
