// The security side of a participant: which peers it authenticates, what they may do, and the
// exchange of keys (DDS-Security 1.2, clauses 7.5.3 and 9.8). Sends only through the sender; has no
// clock and no lock. It connects these parts, which do the work:
//
//   MemoryExchange        shares memory with peers on the same machine
//   GovernanceTransition  puts more protection into force while participants run
//   Handshakes            authenticates the peers, and limits what that costs
//   DormantPeers          keeps the keys of peers that were not heard and may hear us
//   KeyReviser            creates new keys for all others when a peer loses its trust
//   CryptoTokenExchange   exchanges key tokens through the volatile secure endpoints
//   Admission             decides which participants may authenticate, and which endpoints match
//   SecurityCore          is used by all of them: has the peers (see peer.hpp), the keyring, the
//                         local identity
//
// Each part calls only those below it.
#pragma once

#include "rtps/security/document_renewal.hpp"
#include "rtps/security/governance_transition.hpp"
#include "rtps/security/handshakes.hpp"

namespace ddssec::rtps {

class MemoryExchange;

/// The interface of rtps/security to the participant. Not thread-safe: the caller serializes calls.
class Security {
 public:
  using AdmissionDecision = Admission::Decision;

  /// The owner must run `timers` and call tick at the times that they ask for (next_tick).
  Security(std::unique_ptr<OwnSecurity> own, MessageSender& sender, TimerQueue& timers,
           SecurityHost& host, EventSink& events);
  ~Security();

  OwnSecurity& own() { return *core_.own; }
  Keyring& keyring() { return core_.keyring; }

  /// Registers the builtin endpoints. Call SecurityCore::set_own_data before. Errors: those of the
  /// plugins.
  Status start();

  /// Decides what to do with a participant that announced itself (Admission).
  AdmissionDecision judge(const ParticipantData& data) { return admission_.judge(data); }
  bool may_authenticate(const ParticipantData& data) const {
    return admission_.may_authenticate(data);
  }
  std::optional<Admission::Permission> admit(const EntityId& local,
                                             const Admission::Endpoint& remote) {
    return admission_.admit(local, remote);
  }
  Result<Admission::AnnouncedSecurity> create_endpoint(const EntityId& id,
                                                       const Admission::NewEndpoint& endpoint) {
    auto created = admission_.create_endpoint(id, endpoint);
    if (!created) forget_endpoint(id);
    return created;
  }

  /// Returns the part that decides about the partitions of local endpoints, and their announcement.
  Admission& admission() { return admission_; }
  void forget_endpoint(const EntityId& id) {
    admission_.forget_endpoint(id);
    core_.keyring.remove_local(id);
  }

  /// Begins or continues the handshake with an announced participant (Handshakes).
  void discovered(const ParticipantData& data, const AnnouncedAddresses& addresses,
                  MonotonicTime now);
  void announced_again(const ParticipantData& data, const AnnouncedAddresses& addresses,
                       MonotonicTime now);
  /// Notes that a participant announces itself. Raises session_not_resumed, once, if it is
  /// authenticated and has ended the session a while ago.
  void note_announced(const GuidPrefix& prefix, MonotonicTime now);
  /// Notes that this many more octets may be sent to the peer.
  void note_credit(const GuidPrefix& prefix, std::size_t octets) {
    if (auto* peer = core_.find(prefix)) handshakes_.note_credit(*peer, octets);
  }
  void on_stateless(const GuidPrefix& source, BytesView payload, MonotonicTime now);
  void on_stateless_frag(const GuidPrefix& source, const DataFrag& frag, const SourceAddress& from,
                         MonotonicTime now);
  void note_key_exchange(const GuidPrefix& prefix);
  /// Notes that the peer acknowledged messages of the key exchange.
  void note_keys_acknowledged(const GuidPrefix& prefix);

  /// Returns nullptr if shared memory is off.
  MemoryExchange* memory() const { return memory_.get(); }
  /// Returns the attributes before the last change of the domain, once after it has ended.
  std::optional<spi::ParticipantSecurityAttributes> take_former_domain() {
    return governance_change_.take_former_domain();
  }

  /// Returns the core, for events about peers and for counters.
  SecurityCore& core() { return core_; }

  /// Removes a participant and its keys. Returns a message to send to a participant that is no
  /// longer trusted and may keep the session: in Cyclone DDS, a renewal list may let it.
  std::optional<Bytes> lost(const GuidPrefix& prefix);
  /// Returns the peers whose keys are kept. Only DormantPeers::keep may be called instead of
  /// `lost`.
  DormantPeers& dormant() { return dormant_; }
  /// Adds a dormant peer that has answered. It must not be known. Returns false if that is not
  /// possible any more.
  bool wake(const GuidPrefix& prefix);
  bool is_authenticated(const GuidPrefix& prefix) const;
  /// True if the participant was discovered as one that authenticates, and was not removed since.
  bool knows(const GuidPrefix& prefix) const { return core_.peers.contains(prefix); }
  /// True if a handshake with the participant has succeeded, even if its keys have not arrived yet.
  bool has_proven_identity(const GuidPrefix& prefix) const;
  /// True if the handshake has neither succeeded nor failed, and is not overdue.
  bool is_authenticating(const GuidPrefix& prefix) const;
  /// True if the participant has sent a handshake message. A participant that only announces itself
  /// is removed before it.
  bool has_spoken(const GuidPrefix& prefix) const;

  /// Queries an authenticated peer. Its keys protect the answer, whatever else is protected.
  void ask_for_sign_of_life(const GuidPrefix& prefix) {
    if (auto* peer = core_.find(prefix)) exchange_.ask_for_sign_of_life(*peer);
  }

  /// Sends to the peer at these addresses from now on.
  void readdress(const GuidPrefix& prefix, const LocatorList& addresses) {
    if (auto* peer = core_.find(prefix)) exchange_.readdress(*peer, addresses);
  }
  CryptoTokenExchange& exchange() { return exchange_; }
  /// Registers a local and a remote endpoint as a pair. Returns true if they can be matched now
  /// (CryptoTokenExchange).
  bool register_pair(const EntityId& local, const Guid& remote, bool is_relay_only = false) {
    return exchange_.register_pair(local, remote, is_relay_only);
  }

  /// Notes that the application no longer trusts the participant. Call it before `lost`.
  void distrust(const GuidPrefix& prefix);
  /// Creates new keys for the peers that are trusted now. Errors: rtps_key_revision_disabled.
  Status revise_keys();

  void tick(MonotonicTime now);
  MonotonicTime next_tick() const;

 private:
  void expire();
  /// Returns the peers for which `ended(identity, permissions)` is true.
  template <class F>
  std::vector<GuidPrefix> peers_if(F&& ended) const;

  GovernanceChangeState governance_change_;  // before core_, which refers to it
  SecurityCore core_;
  Admission admission_{core_};
  CryptoTokenExchange exchange_{core_};
  KeyReviser key_reviser_{core_, exchange_};
  DormantPeers dormant_{core_, exchange_, key_reviser_};
  Handshakes handshakes_{core_, admission_, exchange_, key_reviser_, dormant_};
  DocumentRenewal renewal_{core_, exchange_, key_reviser_};
  GovernanceTransition change_{governance_change_, core_, admission_, exchange_, key_reviser_};
  std::unique_ptr<MemoryExchange> memory_;  ///< nullptr: shared memory is off
  MonotonicTime next_expiry_{};
};

}  // namespace ddssec::rtps
