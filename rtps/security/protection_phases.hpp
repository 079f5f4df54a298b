// The two protections that a local participant has while its governance changes.
#pragma once

#include "rtps/security/message_keys.hpp"

namespace ddssec::rtps {

/// The second protections of endpoints and of messages, and by which of the two each peer says that
/// it sends (GovernanceTransition). No I/O, clock or lock.
///
/// One of the two documents counts for a message, never a layer of each: until the swap the former
/// one, which demands no more than the next one in any layer (governance::live_change). After the
/// swap the former one still counts for peers that have not said that they send by the next one.
class ProtectionPhases {
 public:
  /// `locals`: the endpoints with the protection that counts when they send.
  ProtectionPhases(OwnSecurity& own, Remotes& remotes, Locals& locals, EndpointKeys& keys)
      : remotes_(remotes), locals_(locals), endpoints_(locals, keys), messages_(own, remotes) {}

  SecondProtections& endpoints() { return endpoints_; }
  const SecondProtections& endpoints() const { return endpoints_; }
  MessageKeys& messages() { return messages_; }
  const MessageKeys& messages() const { return messages_; }

  /// From now on the second protections are the first ones, and the other way round.
  void swap() noexcept;
  void remove_second();
  /// Whether the peer says that it sends by the document that comes into force here. Once it does
  /// so, it does until the second protections are removed: it may have taken a later document.
  void note_sends_next(const GuidPrefix& peer, bool sends_next);
  bool has_swapped() const { return has_swapped_; }
  /// True if the next document counts here, but the peer may still send by the former one.
  bool may_send_by_former(const GuidPrefix& peer) const;
  /// True if messages of the participant are taken only if its own key protects them. Plain builtin
  /// endpoints of some vendors are excepted.
  bool must_protect_messages(const GuidPrefix& peer) const;
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
