// The second protection of local endpoints while their governance changes.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "rtps/security/endpoint_keys.hpp"

namespace ddssec::rtps {

/// A second protection of local endpoints, while one governance document replaces another
/// (GovernanceTransition). Messages with either protection are opened; messages are sent with the
/// first one. Each protection has its own keys.
class SecondProtections {
 public:
  /// `first` has the endpoints with the protection that counts when they send.
  SecondProtections(Locals& first, EndpointKeys& keys) : first_(first), keys_(keys) {}

  /// Gives the endpoint a second protection. Errors: those of the plugin.
  Status add(const EntityId& id, const spi::EndpointSecurityAttributes& attributes);
  /// Returns the second protection, or nullptr.
  const spi::EndpointSecurityAttributes* attributes(const EntityId& id) const;
  /// Returns the same with its keys, if a pair with `remote` has it, or nullptr.
  const LocalKeys* second_keys_of(const EntityId& id, const Guid& remote) const;
  /// Swaps the first and the second protection of every endpoint.
  void swap() noexcept;
  void remove_all();
  /// Removes the second protection of the endpoint, if it has one.
  void remove(const EntityId& id);
  /// Unregisters the pair's second keys. If the pair returns, set_permitted() must be called again.
  void unregister_pair(const EntityId& id, const Guid& remote, AfterMatch after = AfterMatch::gone);
  /// Registers the pair again. Second keys that were kept are used again, if the pair may have them
  /// and did not change between relay-only and ordinary. Our keys are sent to the remote endpoint
  /// again. Returns true if the second keys are doubtful (PairKeys).
  bool resume(const EntityId& id, const Guid& remote, bool is_relay_only);
  /// Drops the keys of the pair for both protections. Does nothing if no pair is named.
  void drop_keys(const EntityId& id, const std::optional<Guid>& remote);
  /// As unregister_pair, for all pairs with endpoints of that peer.
  void unregister_pairs_of(const GuidPrefix& remote);

  /// Returns the first protection; 0 for an unknown endpoint.
  ProtectionId first_protection_of(const EntityId& id) const;
  /// True if the endpoint has that protection as first or second one.
  bool knows(const EntityId& id, ProtectionId protection) const;
  /// Returns the first or second protection with its keys, whichever is `protection`; 0 means the
  /// first one. Returns nullptr if neither is.
  LocalKeys* find(const EntityId& id, ProtectionId protection);
  /// Notes whether the pair may have keys for both protections. Until that is noted, it may not.
  void set_permitted(const EntityId& id, const Guid& remote, bool may);
  /// Notes whether the remote endpoint is announced only with the second protection.
  void note_announced(const EntityId& id, const Guid& remote, bool with_second);
  /// True if an endpoint of that peer is announced only with the second protection.
  bool any_announced_with_second(const GuidPrefix& prefix) const;
  /// True if a pair with an endpoint of that peer exists whose local endpoint has two protections.
  bool has_pair_under_two_protections(const GuidPrefix& prefix) const;
  /// Notes that keys of second protections must be sent once more, to endpoints of that peer.
  void send_again(const GuidPrefix& prefix);
  /// As send_again(prefix), for one pair.
  void send_again(const EntityId& id, const Guid& remote);
  /// Returns the pairs with endpoints of that peer that have one protection and lack the other
  /// one, or whose keys must be sent.
  std::vector<std::pair<EntityId, Guid>> incomplete_pairs(const GuidPrefix& prefix) const;
  /// The result of complete() and revised_tokens().
  struct Completion {
    /// The protection under which the pair was registered now; 0 if it lacked none.
    ProtectionId protection = 0;
    std::vector<spi::Token> tokens = {};  ///< to be sent to the remote endpoint
  };
  /// Registers the pair also under the protection under which it is not registered yet. Errors:
  /// those of the plugin.
  Result<Completion> complete(const EntityId& id, const Guid& remote);
  /// Returns the second protection and its keys of the revision under way, for the remote endpoint
  /// of a pair that may have them. Without a revision or such a pair there are none. Errors: those
  /// of the plugin.
  Result<Completion> revised_tokens(const EntityId& id, const Guid& remote);
  /// Adds the pairs with endpoints of that peer that have keys of a second protection.
  void add_pairs_with_keys(const GuidPrefix& prefix, std::set<std::pair<EntityId, Guid>>& to) const;

 private:
  /// Local endpoints, each with its remote ones.
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
