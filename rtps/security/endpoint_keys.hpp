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

/// Names the protection of an endpoint: its two masks. 0: none is named.
using ProtectionId = std::uint64_t;
ProtectionId protection_id(const spi::EndpointSecurityAttributes& attributes);

/// A local endpoint's keys with one remote endpoint.
struct PairKeys {
  std::int64_t handle = 0;  ///< handle of the remote endpoint; 0: no keys at all
  bool is_ready = false;
  bool is_relay_only = false;
  bool is_suspended = false;
  bool is_silent = false;  ///< nothing is protected for it but what is sent to it alone
  Sha256Digest keys = {};  ///< digest of its latest tokens
  std::optional<std::size_t> place = {};  ///< index in the lists of ready pairs
};

/// What becomes of the keys of a pair that is no longer matched.
enum class AfterMatch : std::uint8_t {
  gone,        ///< they are dropped
  may_return,  ///< the pair is suspended: nothing is protected for it, or opened
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
  std::vector<PairKeys*> is_ready = {};                   ///< the pairs of either list
  IdlePairs idle = {};                                    ///< those that are in neither list
  /// Adds a pair to the lists if it is ready, or removes it, without iterating over the others.
  void list(const EntityId& id, const Guid& remote, PairKeys& pair);
  void unlist(const EntityId& id, PairKeys& pair);
  /// The pair is in neither list, and has keys. Returns the pair whose keys must be given up in
  /// exchange, if any.
  std::optional<Guid> note_idle(const Guid& remote, const PairKeys& pair);
};
using Locals = std::map<EntityId, LocalKeys>;
/// Returns nullptr if it is not there.
const LocalKeys* find(const Locals& locals, const EntityId& id);

/// An authenticated remote participant.
struct RemoteCrypto {
  spi::ParticipantCryptoHandle crypto;
  std::shared_ptr<const spi::SharedSecret> secret;
  bool wraps_plain_builtin = true;
  Sha256Digest keys = {};  ///< digest of its latest tokens
};
using Remotes = std::map<GuidPrefix, RemoteCrypto>;

/// A pair that was registered, or found.
struct PairRegistration {
  bool is_ready = false;  ///< the keys have arrived, or none are needed
  bool is_new = false;
  std::vector<spi::Token> tokens = {};  ///< to be sent to the remote endpoint, if the pair is new
  /// The pair of the same local endpoint that must be unregistered in exchange (IdlePairs).
  std::optional<Guid> displaced = {};
};

/// Registers them with the plugin, and returns the handles.
class EndpointKeys {
 public:
  EndpointKeys(OwnSecurity& own, const Remotes& remotes) : own_(own), remotes_(remotes) {}

  /// Errors: those of the plugin.
  Status add(Locals& to, const EntityId& id, LocalKeys local);
  void remove(Locals& from, const EntityId& id);
  /// Errors: crypto_not_matched (the remote participant is not known), those of the plugin.
  Result<PairRegistration> register_pair(const EntityId& id, LocalKeys& local, const Guid& remote,
                                         bool is_relay_only);
  /// See Keyring::unregister_pair. Returns the pair that must be unregistered in exchange
  /// (IdlePairs), if any.
  std::optional<Guid> unregister_pair(Locals& from, const EntityId& id, const Guid& remote,
                                      AfterMatch after);
  /// The same for all endpoints of the participant.
  void unregister_pairs_of(Locals& from, const GuidPrefix& remote);
  Result<std::vector<spi::Token>> tokens_for(const EntityId& id, const LocalKeys& local,
                                             const PairKeys& pair,
                                             spi::KeyStage stage = spi::KeyStage::in_use);
  /// The remote endpoint of a pair, and the protection that has it.
  struct Endpoint {
    Guid guid;
    ProtectionId protection;
  };
  /// Returns nullptr for an unknown handle.
  const Endpoint* endpoint_of(std::int64_t handle) const;

 private:
  Status register_local(const EntityId& id, LocalKeys& local);
  Result<std::int64_t> register_with_plugin(const EntityId& id, const LocalKeys& local,
                                            const RemoteCrypto& remote, bool is_relay_only);
  spi::CryptoKeyFactory& factory() { return own_.plugins().cryptography.key_factory(); }

  OwnSecurity& own_;
  const Remotes& remotes_;
  std::unordered_map<std::int64_t, Endpoint> endpoint_of_;
};

/// Another protection of local endpoints, while a governance document takes the place of another
/// one (GovernanceTransition). Messages with either protection are opened; the first one protects
/// what is sent. Each has keys of its own.
class SecondProtections {
 public:
  /// `first`: the endpoints with the protection that counts when they send.
  SecondProtections(Locals& first, EndpointKeys& keys) : first_(first), keys_(keys) {}

  /// The endpoint gets a second protection. Errors: those of the plugin.
  Status add(const EntityId& id, const spi::EndpointSecurityAttributes& attributes);
  /// The second protection, or nullptr.
  const spi::EndpointSecurityAttributes* attributes(const EntityId& id) const;
  /// The same with its keys, if a pair with `remote` has it.
  const LocalKeys* of(const EntityId& id, const Guid& remote) const;
  /// From now on the second protection of each endpoint is the first one, and the other way round.
  void swap() noexcept;
  void remove_all();
  void remove(const EntityId& id);
  void unregister_pair(const EntityId& id, const Guid& remote);
  /// Drops the keys for both protections, if a pair is named.
  void give_up(const EntityId& id, const std::optional<Guid>& remote);
  void unregister_pairs_of(const GuidPrefix& remote);

  /// The first protection; 0: unknown endpoint.
  ProtectionId first_of(const EntityId& id) const;
  /// True if the endpoint has that protection as first or second one.
  bool has(const EntityId& id, ProtectionId protection) const;
  /// The second protection with its keys, if it is that one; or nullptr.
  LocalKeys* find(const EntityId& id, ProtectionId protection);
  /// Whether the pair may have keys for both protections. As long as nothing is said, it may not.
  /// If it has keys of the protection that is to come, that protection is removed: it needs new
  /// keys.
  void permit(const EntityId& id, const Guid& remote, bool may);
  /// The remote endpoint is announced with the first protection, or only with the second one.
  void note_announced(const EntityId& id, const Guid& remote, bool with_second);
  /// True if an endpoint of that peer is announced only with the second protection.
  bool any_announced_with_second(const GuidPrefix& prefix) const;
  /// True if a pair with an endpoint of that peer exists whose local endpoint has two protections.
  bool any_with(const GuidPrefix& prefix) const;
  /// The pairs with endpoints of that peer that one protection has and the other one lacks.
  std::vector<std::pair<EntityId, Guid>> incomplete_pairs(const GuidPrefix& prefix) const;
  struct Completion {
    ProtectionId protection = 0;          ///< the one that has the pair now; 0: nothing was missing
    std::vector<spi::Token> tokens = {};  ///< to be sent to the remote endpoint
  };
  /// Registers such a pair for the protection that lacks it. Errors: those of the plugin.
  Result<Completion> complete(const EntityId& id, const Guid& remote);

 private:
  /// Of local endpoints, with the remote ones.
  using Pairs = std::map<EntityId, std::set<Guid>>;
  bool is_permitted(const EntityId& id, const Guid& remote) const;
  static void forget(Pairs& from, const EntityId& id, const Guid& remote);

  Locals& first_;
  EndpointKeys& keys_;
  Locals others_;
  Pairs permitted_;
  Pairs announced_with_second_;
};

}  // namespace ddssec::rtps
