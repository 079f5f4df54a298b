// The crypto handles of local endpoints and of their pairs with remote ones.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <unordered_map>
#include <vector>

#include "base/hash.hpp"
#include "rtps/security/idle_pairs.hpp"
#include "rtps/security/own_security.hpp"

namespace ddssec::rtps {

/// Identifies the protection of an endpoint by its two masks. 0 identifies none.
using ProtectionId = std::uint64_t;
ProtectionId protection_id(const spi::EndpointSecurityAttributes& attributes);

/// A local endpoint's keys with one remote endpoint.
struct PairKeys {
  std::int64_t handle = 0;  ///< handle of the remote endpoint; 0: no keys at all
  bool is_ready = false;
  bool is_relay_only = false;
  bool is_suspended = false;
  /// The remote endpoint's keys may be former ones: they may have been revised since the pair was
  /// suspended.
  bool are_keys_doubtful = false;
  bool is_silent = false;  ///< only messages to this endpoint alone are protected for it
  bool is_unsent = false;  ///< a second protection: the remote endpoint needs its keys once more
  Sha256Digest keys = {};  ///< digest of its latest tokens
  std::optional<std::size_t> place = {};  ///< index in the lists of ready pairs
};

/// The fate of the keys of a pair that is no longer matched.
enum class AfterMatch : std::uint8_t {
  gone,        ///< they are dropped
  may_return,  ///< the pair is suspended: nothing is protected for it or opened with its keys
  /// The remote reader does not answer. Messages to all readers contain nothing for it, but it may
  /// still be asked, and its answer can be opened.
  silent,
};

/// A local endpoint under one protection.
struct LocalKeys {
  spi::EndpointSecurityAttributes attributes;
  bool is_volatile = false;
  ProtectionId protection = protection_id(attributes);
  spi::PropertyList properties = {};
  std::int64_t handle = 0;  ///< 0: nothing to protect
  std::map<Guid, PairKeys> pairs = {};
  std::vector<spi::DatareaderCryptoHandle> readers = {};  ///< for a writer: the ready readers
  std::vector<spi::DatawriterCryptoHandle> writers = {};  ///< for a reader: the ready writers
  /// The pairs whose handles are in `readers` or `writers`, in the same order.
  std::vector<PairKeys*> ready_pairs = {};
  IdlePairs idle = {};  ///< the pairs that are in neither list
  /// Adds a pair to the lists if it is ready, or removes it, without iterating over the others.
  void list(const EntityId& id, const Guid& remote, PairKeys& pair);
  void unlist(const EntityId& id, PairKeys& pair);
  /// Notes a pair that is in neither list and has keys. Returns the pair whose keys must be given
  /// up in exchange, if any.
  std::optional<Guid> note_idle(const Guid& remote, const PairKeys& pair);
  /// Returns a digest of the remote endpoint's latest tokens; empty if none have come, or if they
  /// protect no submessages.
  std::optional<Sha256Digest> submessage_tokens_of(const Guid& remote) const;
};
using Locals = std::map<EntityId, LocalKeys>;
/// Returns nullptr if there is no such endpoint.
const LocalKeys* find(const Locals& locals, const EntityId& id);

/// An authenticated remote participant.
struct RemoteCrypto {
  spi::IdentityHandle identity;
  spi::PermissionsHandle permissions;
  std::shared_ptr<const spi::SharedSecret> secret;
  bool wraps_plain_builtin = true;
  bool answers_key_requests = false;
  /// It sends by the governance document that comes into force here: it says so, or was judged by
  /// that document when it authenticated (GovernanceTransition).
  bool sends_next = false;
  bool says_next = false;  ///< it has said so: its former keys count no more
  spi::ParticipantCryptoHandle crypto = {};
  /// Digests of its latest keys for each protection of messages.
  std::map<ProtectionId, Sha256Digest> keys = {};
};
using Remotes = std::map<GuidPrefix, RemoteCrypto>;

/// A pair that was registered, or found.
struct PairRegistration {
  bool is_ready = false;  ///< the keys have arrived, or none are needed
  bool is_new = false;
  bool are_keys_doubtful = false;       ///< see PairKeys; they are requested again
  std::vector<spi::Token> tokens = {};  ///< to be sent to the remote endpoint, if the pair is new
  /// The pair of the same local endpoint that must be unregistered in exchange (IdlePairs).
  std::optional<Guid> displaced = {};
};

/// Registers local endpoints and pairs with the plugin, and keeps the handles.
class EndpointKeys {
 public:
  EndpointKeys(OwnSecurity& own, const Remotes& remotes) : own_(own), remotes_(remotes) {}

  /// Adds a local endpoint. Errors: those of the plugin.
  Status add(Locals& to, const EntityId& id, LocalKeys local);
  void remove(Locals& from, const EntityId& id);
  /// Registers a pair. Errors: crypto_not_matched (the remote participant is not known), those of
  /// the plugin.
  Result<PairRegistration> register_pair(const EntityId& id, LocalKeys& local, const Guid& remote,
                                         bool is_relay_only);
  /// See Keyring::unregister_pair. Returns the pair that must be unregistered in exchange
  /// (IdlePairs), if any.
  std::optional<Guid> unregister_pair(Locals& from, const EntityId& id, const Guid& remote,
                                      AfterMatch after);
  /// Ends the suspension of a pair. If its keys are doubtful, and the remote participant can be
  /// asked for them, it is not ready before they come.
  void resume(const EntityId& id, LocalKeys& local, const Guid& remote, PairKeys& pair) const;
  /// As unregister_pair, for all endpoints of the participant.
  void unregister_pairs_of(Locals& from, const GuidPrefix& remote);
  Result<std::vector<spi::Token>> tokens_for(const EntityId& id, const LocalKeys& local,
                                             const PairKeys& pair,
                                             spi::KeyStage stage = spi::KeyStage::in_use);
  /// What all pairs with a remote endpoint, under one protection, have in common.
  struct NewestKeys {
    spi::KeyRevision revision = 0;  ///< the latest that any of the pairs has tokens of
    std::size_t pairs = 0;
  };
  /// The two endpoints of a pair, and the protection under which the pair is registered.
  struct Endpoint {
    Guid guid;
    ProtectionId protection;
    EntityId local;
    NewestKeys* newest = nullptr;  ///< never nullptr for a known handle
  };
  /// Returns nullptr for an unknown handle.
  const Endpoint* endpoint_of(std::int64_t handle) const;
  /// Notes the revision of a remote endpoint's keys. It counts for all pairs with the endpoint: a
  /// message for several of them is opened by way of one. An earlier one than before changes
  /// nothing.
  void note_revision(std::int64_t handle, spi::KeyRevision revision);

 private:
  Status register_local(const EntityId& id, LocalKeys& local);
  void forget(std::int64_t handle);
  Result<std::int64_t> register_with_plugin(const EntityId& id, const LocalKeys& local,
                                            const RemoteCrypto& remote, bool is_relay_only);
  spi::CryptoKeyFactory& factory() { return own_.plugins().cryptography.key_factory(); }

  OwnSecurity& own_;
  const Remotes& remotes_;
  std::unordered_map<std::int64_t, Endpoint> endpoint_of_;
  std::map<std::pair<Guid, ProtectionId>, NewestKeys> newest_;
};

}  // namespace ddssec::rtps
