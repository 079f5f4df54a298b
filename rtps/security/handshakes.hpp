// Authenticates the peers (DDS-Security 8.8.2): takes what the stateless endpoint brings, sends
// what their handshakes want to say, and limits what all of that costs.
#pragma once

#include "rtps/budget/source_budget.hpp"
#include "rtps/budget/subject_shares.hpp"
#include "rtps/security/admission.hpp"
#include "rtps/security/fragment_store.hpp"
#include "rtps/security/handshake_sender.hpp"
#include "rtps/security/key_revision.hpp"

namespace ddssec::rtps {

/// Where a participant is said to be, and who said so.
struct AnnouncedAddresses {
  const LocatorList& metatraffic;
  std::span<const SourceAddress> sources;  ///< that announced each of them
  const SourceAddress& source;             ///< of the present announcement
};

class Handshakes {
 public:
  /// Messages that a peer gets for one announcement before it says a word.
  static constexpr int kMessagesUnasked = 2;
  /// Participants that can have authenticated at a time. One certificate never takes the last
  /// places.
  static constexpr std::size_t kMaxAuthenticated = 480;
  /// Handshakes that we begin with peers that never spoke, by the source of their announcements: so
  /// many at once, one each so long.
  static constexpr int kMaxStarts = 32;
  static constexpr MonotonicTime kStartPeriod = std::chrono::milliseconds(25);
  /// Messages repeated to peers that never spoke, of all.
  static constexpr MonotonicTime kSilentPeriod = std::chrono::milliseconds(200);
  /// Handshake messages of all peers that cost public-key work.
  static constexpr int kMaxMessages = 200;
  static constexpr MonotonicTime kMessagePeriod = std::chrono::microseconds(2500);
  /// So many messages of one peer count as few.
  static constexpr int kFewMessages = 12;
  static constexpr MonotonicTime kFewPeriod = std::chrono::milliseconds(250);
  /// Peers with a refused message, or with more than a few, are limited separately.
  static constexpr MonotonicTime kLoudRequestPeriod = std::chrono::microseconds(1500);
  static constexpr MonotonicTime kLoudEchoPeriod = std::chrono::microseconds(1000);
  /// What our answers to requests of peers that did not go on take, of all peers. A fair share, 32
  /// KiB for each, is never lost.
  static constexpr std::size_t kMaxAnswerOctets = std::size_t{16} << 20;
  /// Messages that are repeated because something had to be dropped, of all peers.
  static constexpr int kMaxResendRequests = 20;
  static constexpr MonotonicTime kResendRequestPeriod = std::chrono::milliseconds(20);
  /// Answers known by heart, of all peers.
  static constexpr MonotonicTime kRepetitionPeriod = std::chrono::milliseconds(2);
  /// Where unauthenticated participants are allowed, a peer whose handshake has not succeeded after
  /// this time is treated as one, and its handshake goes on: nothing that is sent in its name makes
  /// this sooner or final.
  static constexpr MonotonicTime kAdmissionPatience = std::chrono::seconds(3);
  /// A peer whose keys do not come for so long after its handshake is asked for another.
  static constexpr MonotonicTime kConfirmation = std::chrono::seconds(10);
  /// Where messages are not protected a peer without participant tokens has joined after so long,
  /// if the key exchange works: OpenDDS sends none there.
  static constexpr MonotonicTime kTokenPatience = std::chrono::seconds(1);
  /// How often a peer that asks again, as if it had forgotten us, is probed.
  static constexpr MonotonicTime kProbePeriod = std::chrono::seconds(5);
  /// Time for its answer, by the keys that it has: the question for a handshake may be forged.
  static constexpr MonotonicTime kProbePatience = std::chrono::seconds(2);

  Handshakes(SecurityCore& core, const Admission& admission, KeyExchange& exchange,
             KeyRevision& revision)
      : core_(core), admission_(admission), exchange_(exchange), revision_(revision) {}

  /// c.pdata of ours, a big-endian parameter list, before anything else.
  void set_own_data(Bytes own_data) {
    own_data_ = std::make_shared<const Bytes>(std::move(own_data));
  }

  /// A participant that can authenticate announced itself for the first time.
  void add(const ParticipantData& data, const AnnouncedAddresses& addresses);
  /// A different announcement for a peer that has not authenticated yet; it may be the genuine one.
  void announced_again(const ParticipantData& data, const AnnouncedAddresses& addresses);
  /// Any announcement: it may have been there to hear us.
  void note_announced(Peer& peer) { peer.was_announced = true; }
  /// So many octets more may be sent to it (AmplificationLimit).
  void note_earned(Peer& peer, std::size_t octets);
  void remove(const GuidPrefix& prefix) { fragments_.forget(prefix); }

  void on_stateless(const GuidPrefix& source, BytesView payload);
  void on_stateless_frag(const GuidPrefix& source, const DataFrag& frag, const SourceAddress& from);
  /// A message that only the peer can have protected came by the volatile secure channel.
  void note_key_exchange(Peer& peer);

  void tick();
  MonotonicTime next_tick() const { return next_; }

 private:
  /// For peers that behave, and for loud ones.
  struct Limits {
    WorkBudget few, loud;
  };

  std::unique_ptr<PeerHandshake> handshake_with(const ParticipantData& data);
  LocatorList addresses_of(const Peer& peer) const;
  void send(Peer& peer, const PeerHandshake::Messages& messages);
  void on_auth_request(Peer& peer, const GenericMessage& message);
  void on_authentication(Peer& peer, const GenericMessage& message);
  bool may_spend(Peer& peer, Effort effort);
  void request_resend(const Peer& peer);
  /// The peer whose answers take most gives way, until there is room for one more.
  void make_room_for_answer();

  /// Takes the edges that the handshake has reached. True: the peer has just been associated.
  bool advance(Peer& peer);
  Result<Association> associate(Peer& peer);
  Result<PeerPermissions> permissions_of(const Peer& peer);
  Status register_keys(const Peer& peer, Association& association);
  Status adopt_proven_data(Peer& peer);
  void open_channel(Peer& peer);
  /// May one more participant of its certificate authenticate? Before it did, this asks for the
  /// certificate that it claims to have: no other peer loses by that.
  bool has_place(const Peer& peer) const;
  Error no_place_for(const Peer& peer);
  void try_later(Peer& peer);
  void refuse(Peer& peer);
  void note_failure(Peer& peer);

  void tick(Peer& peer);
  bool may_tick(Peer& peer);
  void tick_association(Peer& peer);
  void note_overdue(Peer& peer);
  void end_probe(Peer& peer);
  /// When it is to be admitted without authentication; never, if it is not.
  MonotonicTime next_admission(const Peer& peer) const;
  void admit_meanwhile(Peer& peer);
  /// When the association wants something.
  MonotonicTime next_of_association(const Peer& peer) const;
  /// The peer may have something to do earlier than all did before.
  void schedule(const Peer& peer);

  SecurityCore& core_;
  const Admission& admission_;
  KeyExchange& exchange_;
  KeyRevision& revision_;
  std::shared_ptr<const Bytes> own_data_;
  HandshakeAccount account_;
  HandshakeSender messages_{core_.sender};
  FragmentStore fragments_;
  SubjectShares subjects_{kMaxAuthenticated};
  SourceBudget starts_{kMaxStarts, kStartPeriod};
  SourceBudget silent_{kMaxStarts, kSilentPeriod};
  WorkBudget spoken_starts_{kMaxMessages, kMessagePeriod, {}};
  Limits requests_{{kMaxMessages, kMessagePeriod, {}}, {kMaxMessages, kLoudRequestPeriod, {}}};
  Limits echoes_{{kMaxMessages, kMessagePeriod, {}}, {kMaxMessages, kLoudEchoPeriod, {}}};
  WorkBudget repetitions_{kMaxMessages, kRepetitionPeriod, {}};
  WorkBudget resend_requests_{kMaxResendRequests, kResendRequestPeriod, {}};
  MonotonicTime next_ = kNever;  ///< no peer has anything to do before
};

}  // namespace ddssec::rtps
