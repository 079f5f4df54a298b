// The two protections that a local participant has while its governance changes.
#pragma once

#include "rtps/security/message_keys.hpp"
#include "rtps/security/second_protections.hpp"

namespace ddssec::rtps {

/// The second protections of endpoints and of messages, and by which of the two each peer says that
/// it sends (GovernanceTransition). No I/O, clock or lock.
///
/// One of the two documents counts for a message, never a layer of each: the next one for peers
/// that say that they send by it, the former one for all others. It demands no more than the next
/// one in any layer (governance::live_change). Keys of either protection are taken from a peer
/// until it says so, and then only those of the next one: others have its former keys, too.
class ProtectionPhases {
 public:
  /// `locals`: the endpoints with the protection that counts when they send.
  ProtectionPhases(OwnSecurity& own, Remotes& remotes, Locals& locals, EndpointKeys& keys)
      : remotes_(remotes), locals_(locals), endpoints_(locals, keys), messages_(own, remotes) {}

  SecondProtections& endpoints() { return endpoints_; }
  const SecondProtections& endpoints() const { return endpoints_; }
  MessageKeys& messages() { return messages_; }
  const MessageKeys& messages() const { return messages_; }

  /// Swaps the first and the second protection of every endpoint and of messages.
  void swap() noexcept;
  void remove_second();
  /// Notes that the peer says that it sends by the document that comes into force here. It does so
  /// until the second protections are removed, also if it has taken a later document since.
  void note_sends_next(const GuidPrefix& peer);
  bool has_swapped() const { return has_swapped_; }
  /// True if the protection that is not sent here is the one that the peer's messages must have at
  /// least: the peer has changed and we have not, or the other way round.
  bool counts_second(const GuidPrefix& peer) const;
  /// True if the remote endpoint no longer sends with the keys of that protection of the local
  /// endpoint, because its participant says that it sends by the next document.
  bool is_former(const EntityId& id, const Guid& remote, ProtectionId protection) const;
  /// The local endpoint under the next protection if the remote endpoint sends only by it, and they
  /// have a pair under two protections; otherwise nullptr.
  const LocalKeys* only_next(const EntityId& id, const Guid& remote) const;
  /// True if messages of the participant are taken only if its own key protects them. Plain builtin
  /// endpoints of some vendors are excepted.
  bool must_protect_messages(const GuidPrefix& peer) const;
  /// The digest of the peer's keys for the protection that its messages must have at least; zeros
  /// if they have not come.
  Sha256Digest message_keys_of(const GuidPrefix& peer) const;
  /// The local endpoint under the protection that messages of the remote one must have at least;
  /// nullptr: it was never added.
  const LocalKeys* demanded(const EntityId& id, const Guid& remote) const;

 private:
  Remotes& remotes_;
  const Locals& locals_;
  SecondProtections endpoints_;
  MessageKeys messages_;
  bool has_swapped_ = false;  ///< the second protections are the former ones
};

}  // namespace ddssec::rtps
