// Authenticates the peers (DDS-Security 1.2, clause 9.8.3): processes messages to the stateless
// endpoint, sends the messages of the handshakes, and limits their cost.
#pragma once

#include <algorithm>
#include <random>

#include "rtps/budget/subject_shares.hpp"
#include "rtps/security/admission.hpp"
#include "rtps/security/dormant_peers.hpp"
#include "rtps/security/fragment_store.hpp"
#include "rtps/security/handshake_budgets.hpp"
#include "rtps/security/handshake_sender.hpp"

namespace ddssec::rtps {

/// The announced addresses of a participant, and the sources of the announcements.
struct AnnouncedAddresses {
  const LocatorList& metatraffic;
  std::span<const SourceAddress> sources;  ///< the sources that announced each address
  const SourceAddress& source;             ///< the source of the current announcement
};

/// Drives the handshakes of one local participant with all of its peers.
class Handshakes {
 public:
  /// The number of messages that a peer is sent for one announcement before it has sent any.
  static constexpr int kMaxUnaskedMessages = 2;
  /// The number of participants that can be authenticated at a time. One certificate never gets the
  /// last places.
  static constexpr std::size_t kMaxAuthenticated = 480;
  /// Limit for the answers to requests of peers that did not continue, for all peers together, in
  /// octets. A fair share of 32 KiB for each peer is always available.
  static constexpr std::size_t kMaxAnswerOctets = std::size_t{16} << 20;
  /// Where unauthenticated participants are allowed, a peer whose handshake has not succeeded after
  /// this time is treated as unauthenticated, and its handshake continues. No message sent in its
  /// name makes this happen sooner or makes it final.
  static constexpr MonotonicTime kAdmissionTimeout = std::chrono::seconds(3);
  /// If a peer's keys have not arrived this long after its handshake, another handshake is
  /// requested.
  static constexpr MonotonicTime kKeysTimeout = std::chrono::seconds(10);
  /// Where messages are not protected, a peer without participant tokens counts as joined after
  /// this time, if the key exchange works. OpenDDS sends no participant tokens in that case.
  static constexpr MonotonicTime kTokenTimeout = std::chrono::seconds(1);
  /// How often a joined peer is probed that requests a handshake again, as if it had lost its
  /// state.
  static constexpr MonotonicTime kProbePeriod = std::chrono::seconds(5);
  /// How long the peer may take to answer a probe with the keys that it has. The request for a
  /// handshake may be forged.
  static constexpr MonotonicTime kProbeTimeout = std::chrono::seconds(2);

  /// The first and the longest time for which a refused peer waits for another try. The time
  /// doubles with each refusal.
  static constexpr MonotonicTime kMinRefusedPause = std::chrono::seconds(5);
  static constexpr MonotonicTime kMaxRefusedPause = std::chrono::seconds(60);

  Handshakes(SecurityCore& core, const Admission& admission, CryptoTokenExchange& exchange,
             KeyReviser& key_reviser, DormantPeers& dormant)
      : core_(core),
        admission_(admission),
        exchange_(exchange),
        key_reviser_(key_reviser),
        dormant_(dormant) {}

  /// Adds a participant that can authenticate, and that announced itself for the first time.
  void add(const ParticipantData& data, const AnnouncedAddresses& addresses);
  /// Handles a different announcement for a peer that has not authenticated yet. It may be the
  /// genuine one.
  void announced_again(const ParticipantData& data, const AnnouncedAddresses& addresses);
  /// Notes that any announcement arrived: the peer may be able to receive messages.
  void note_announced(Peer& peer);
  /// Ends the probe of the peer, if one is running.
  void end_probe(Peer& peer);
  /// Notes that this many more octets may be sent to the peer (AmplificationLimit).
  void note_credit(Peer& peer, std::size_t octets);
  void remove(const GuidPrefix& prefix) { fragments_.forget(prefix); }
  /// Gives refused peers another try at once, because the local documents were renewed.
  void try_all_again();

  void on_stateless(const GuidPrefix& source, BytesView payload);
  void on_stateless_frag(const GuidPrefix& source, const DataFrag& frag, const SourceAddress& from);
  /// Adds a peer that was dormant. It must not be known. Returns false, and drops it, if there is
  /// no place for its certificate.
  bool wake(Peer peer);
  /// Notes that a message arrived on the volatile secure channel that only the peer can have
  /// protected.
  void note_key_exchange(Peer& peer);

  void tick();
  MonotonicTime next_tick() const { return next_; }

 private:
  std::unique_ptr<PeerHandshake> handshake_with(const ParticipantData& data);
  void send(Peer& peer, const PeerHandshake::Messages& messages);
  void on_auth_request(Peer& peer, const GenericMessage& message);
  void on_authentication(Peer& peer, const GenericMessage& message);
  bool may_spend(Peer& peer, Effort effort);
  void request_resend(const Peer& peer);

  /// Makes the state transitions that the handshake has reached. Returns true if the peer has just
  /// been associated.
  bool advance(Peer& peer);
  Result<Association> associate(Peer& peer);
  Result<PeerPermissions> permissions_of(const Peer& peer);
  Status register_keys(const Peer& peer, Association& association);
  Status adopt_proven_data(Peer& peer);
  /// True if one more participant with its certificate may authenticate. Before authentication, the
  /// certificate that the peer claims to have is used; this costs other peers nothing.
  bool has_place(const Peer& peer) const;
  Error no_place_error(const Peer& peer);
  void try_later(Peer& peer);
  void refuse(Peer& peer);
  void note_failure(Peer& peer) {
    if (!std::exchange(peer.was_counted_as_failed, true)) core_.count_failed();
  }
  /// Gives a refused peer another try. Does nothing if too many handshakes begin.
  void try_again(Peer& peer);

  void tick(Peer& peer);
  bool may_tick(Peer& peer);
  void tick_association(Peer& peer);
  void note_overdue(Peer& peer);
  /// Returns when the peer is to be admitted without authentication; kNever if it is not.
  MonotonicTime next_admission(const Peer& peer) const;
  void admit_unauthenticated(Peer& peer);
  /// Returns when the association next has work.
  MonotonicTime next_of_association(const Peer& peer) const;
  /// Moves the next tick forward if this peer has work earlier.
  void schedule(const Peer& peer) { next_ = std::min(next_, next_of(peer)); }
  /// Returns when this peer next has work.
  MonotonicTime next_of(const Peer& peer) const;

  SecurityCore& core_;
  const Admission& admission_;
  CryptoTokenExchange& exchange_;
  KeyReviser& key_reviser_;
  DormantPeers& dormant_;
  HandshakeAccount account_;
  HandshakeSender messages_{core_.sender};
  FragmentStore fragments_;
  SubjectShares subjects_{kMaxAuthenticated};
  HandshakeBudgets budgets_;
  MonotonicTime next_ = kNever;        ///< no peer has work before this time
  std::optional<std::mt19937> turns_;  ///< chooses the peer that comes first
};

}  // namespace ddssec::rtps
