// The state that the parts of one participant's security share, and the interface through which
// they call the participant.
#pragma once

#include <map>

#include "rtps/security/dormant_peer.hpp"
#include "rtps/security/governance_change_state.hpp"
#include "rtps/security/keyring.hpp"
#include "rtps/security/security_counters.hpp"

namespace ddssec::rtps {

/// The participant, as the parts of its security call it. Called from within receive, tick and
/// register_pair.
class SecurityHost {
 public:
  virtual ~SecurityHost() = default;
  /// Called when the peer's keys have arrived: builtin endpoints may be matched.
  virtual void on_authenticated(const GuidPrefix& peer) = 0;
  /// Called if the peer did not authenticate, has not authenticated yet, or is not allowed to join.
  virtual void on_unauthenticated(const GuidPrefix& peer) = 0;
  /// Called when the peer has authenticated. `proven` is the data that it signed. Returns the
  /// addresses at which it can be reached.
  virtual LocatorList on_proven(const GuidPrefix& peer, const ParticipantData& proven) = 0;
  /// Called if the keys of a peer that authenticated have not arrived for some time. It may have to
  /// be reached at other addresses.
  virtual void on_unconfirmed(const GuidPrefix& peer) = 0;
  /// Called when the peer has authenticated again: everything that was agreed on before has ended.
  virtual void on_replaced(const GuidPrefix& peer) = 0;
  /// Called when the keys of a registered pair have arrived.
  virtual void on_keys(const EntityId& local, const Guid& remote) = 0;
  /// Called when keys of the remote endpoint for the local one have come that revise the former
  /// ones, and some time after that, when the former ones have ended. Without entities, the keys of
  /// the peer for messages were revised, or all its former ones have ended.
  virtual void on_key_change(const EntityId& local, const Guid& remote, KeyChange change) = 0;
  /// Called when keys of the remote endpoint arrived, and are kept, for a pair that is not
  /// registered.
  virtual void on_early_keys(const EntityId& local, const Guid& remote) = 0;
  /// Called when the peer's permissions, or the local ones, were renewed: endpoints may match that
  /// did not, or no longer match. Returns true if any no longer match.
  virtual bool on_rights_changed(const GuidPrefix& peer) = 0;
  /// Called when the peer's identity or permissions, or the local ones, expired or were revoked, or
  /// when the peer reports that it leaves.
  virtual void on_ended(const GuidPrefix& peer) = 0;
};

/// The shared state. All parts borrow it; it knows none of them. They may change the peers, the
/// keyring and our own identity. They only read the rest: Security and MemoryExchange set the time,
/// and GovernanceTransition changes the governance.
class SecurityCore {
 public:
  /// What the participant gives to its security.
  struct Surroundings {
    MessageSender& sender;
    TimerQueue& timers;
    SecurityHost& host;
    EventSink& events;
  };
  SecurityCore(std::unique_ptr<OwnSecurity> identity, const Surroundings& around,
               const GovernanceChangeState& change)
      : own(std::move(identity)),
        sender(around.sender),
        timers(around.timers),
        host(around.host),
        events(around.events),
        governance_change(change),
        keyring(*own, around.events) {}
  SecurityCore(const SecurityCore&) = delete;
  SecurityCore& operator=(const SecurityCore&) = delete;

  /// Returns nullptr if the participant is not known, or cannot authenticate.
  Peer* find(const GuidPrefix& prefix) {
    const auto at = peers.find(prefix);
    return at == peers.end() ? nullptr : &at->second;
  }
  const Peer* find(const GuidPrefix& prefix) const {
    const auto at = peers.find(prefix);
    return at == peers.end() ? nullptr : &at->second;
  }
  /// True if the peer has the governance document that is in force here, or comes into force.
  bool takes_part(const GuidPrefix& prefix) const {
    const auto* peer = find(prefix);
    const auto* association = peer == nullptr ? nullptr : peer->state.association();
    return association != nullptr && association->governance.takes_part;
  }
  /// True if the participant's liveliness counts only if it is asserted by the secure topic.
  bool must_protect_liveliness(const GuidPrefix& prefix) const {
    const auto& other = governance_change.other_domain();
    const bool by_other = other && keyring.phases().counts_second(prefix);
    return (by_other ? *other : own->attributes()).is_liveliness_protected();
  }
  /// Returns the possible senders of a message that a local endpoint accepts as one of the remote
  /// endpoint.
  EventOrigin origin(const EntityId& local, const Guid& remote) const {
    const auto* demanded = keyring.phases().demanded(local, remote);
    if (demanded == nullptr) return EventOrigin::anyone;
    if (demanded->attributes.is_submessage_protected()) return EventOrigin::its_keys;
    const auto* peer = find(remote.prefix);
    const bool is_wrapped = keyring.phases().must_protect_messages(remote.prefix) &&
                            peer != nullptr &&
                            (!is_plain_builtin(local) || peer->data.vendor != kVendorCyclone);
    return is_wrapped ? EventOrigin::its_keys : EventOrigin::anyone;
  }
  /// Returns the possible senders of the announcement of a remote endpoint.
  EventOrigin origin_of_announcement(const Guid& endpoint, bool by_secure_discovery) const {
    const bool writes = is_writer(endpoint.entity);
    const auto& plain = writes ? kPublicationsReader : kSubscriptionsReader;
    const auto& secure = writes ? kPublicationsSecureReader : kSubscriptionsSecureReader;
    return origin(by_secure_discovery ? secure : plain, endpoint);
  }
  /// Raises an event about this peer.
  void raise(Error error, const Peer& peer, EventOrigin origin) {
    raise(std::move(error), peer.prefix(), peer.name(), origin);
  }
  /// As raise(Error, Peer, EventOrigin), about a participant that may be unknown, or about one of
  /// its endpoints. `guid` is that of the participant or endpoint.
  void raise(Error error, const Guid& guid, EventOrigin origin) {
    raise(std::move(error), guid.prefix, guid.to_string(), origin);
  }
  void raise(Error error, const GuidPrefix& prefix, std::string guid, EventOrigin origin) {
    const auto* peer = origin == EventOrigin::its_keys ? find(prefix) : nullptr;
    auto subject = peer == nullptr ? std::nullopt : proven_subject(*peer);
    events.raise(peer_event(std::move(error), std::move(guid), std::move(subject)));
  }
  /// Returns the subject of the peer's certificate. Empty if the peer has not authenticated, or is
  /// no longer trusted.
  std::optional<std::string> proven_subject(const Peer& peer) const {
    if (const auto* association = peer.state.association()) return association->subject;
    const auto* handshake = peer.state.handshake();
    if (handshake == nullptr || !handshake->is_finished()) return std::nullopt;
    return own->plugins().authentication.authenticated_subject(handshake->handle());
  }

  void set_now(MonotonicTime time) { now_ = time; }
  /// Sets c.pdata of the handshakes that begin from now on: a big-endian parameter list.
  void set_own_data(Bytes data) { own_data_ = std::make_shared<const Bytes>(std::move(data)); }
  const std::shared_ptr<const Bytes>& own_data() const { return own_data_; }
  const AuthenticationCounters& counters() const { return counters_; }
  void count_authenticated() { ++counters_.authenticated; }
  void count_failed() { ++counters_.failed; }

  const std::unique_ptr<OwnSecurity> own;
  MessageSender& sender;
  TimerQueue& timers;
  SecurityHost& host;
  EventSink& events;
  const GovernanceChangeState& governance_change;
  Keyring keyring;
  /// Both are destroyed before the keyring, which contains their keys. A peer that is dormant may
  /// also be among the peers, as one that has not authenticated.
  std::map<GuidPrefix, Peer> peers;
  std::map<GuidPrefix, DormantPeer> dormant;
  const MonotonicTime& now = now_;  ///< the time of the current call

 private:
  MonotonicTime now_{};
  std::shared_ptr<const Bytes> own_data_;
  AuthenticationCounters counters_;
};

}  // namespace ddssec::rtps
