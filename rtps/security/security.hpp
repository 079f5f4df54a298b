// The security side of a participant: whom it authenticates, what they may, and the keys that go to
// and fro (DDS-Security 7.4.3, 8.8). No I/O but through the sender, no clock, no lock.
#pragma once

#include "rtps/budget/work_budget.hpp"
#include "rtps/discovery/participant_data.hpp"
#include "rtps/reliability/stateful_reader.hpp"
#include "rtps/security/fragment_store.hpp"
#include "rtps/security/keyring.hpp"
#include "rtps/security/peer_handshake.hpp"

namespace ddssec::rtps {

/// The participant around it. Called from within receive, tick and introduce.
class SecurityHost {
 public:
  virtual ~SecurityHost() = default;
  /// Its keys are here: builtin endpoints may be matched.
  virtual void on_authenticated(const GuidPrefix& peer) = 0;
  /// It did not authenticate, or not yet, or is not allowed to join.
  virtual void on_refused(const GuidPrefix& peer) = 0;
  /// It authenticated, and this is what it says of itself, proven; where it can be reached.
  virtual LocatorList on_proven(const GuidPrefix& peer, const ParticipantData& proven) = 0;
  /// It authenticated once more: nothing that was agreed on before holds any longer.
  virtual void on_replaced(const GuidPrefix& peer) = 0;
  /// The keys of a pair that was introduced are here.
  virtual void on_keys(const EntityId& local, const Guid& remote) = 0;
  /// Keys of its endpoint came, and are kept, for a pair that was not introduced.
  virtual void on_early_keys(const Guid& remote) = 0;
  /// What let a peer take part, or us, has ended.
  virtual void on_ended(const GuidPrefix& peer) = 0;
};

/// How many peers made it, and how many of whom something was refused.
struct AuthenticationCounters {
  std::uint64_t authenticated = 0;
  std::uint64_t failed = 0;
};

class Security {
 public:
  /// Token messages that are kept for endpoints we do not know yet, of one peer, and their octets.
  static constexpr std::size_t kMostEarlyTokens = 1024;
  static constexpr std::size_t kMostEarlyOctets = std::size_t{512} << 10;
  /// Of one message with tokens: many times what keys take, so that those kept are few octets, too.
  static constexpr std::size_t kMostTokenOctets = 4096;
  /// Of the messages of one peer that came before others of it.
  static constexpr StatefulReader::Limits kVolatileLimits{.largest_sample = 64 << 10,
                                                          .held_octets = std::size_t{1} << 20};
  /// Handshakes that we begin with peers that never spoke: so many at once, one each so long.
  static constexpr int kMostStarts = 32;
  static constexpr MonotonicTime kStartPeriod = std::chrono::milliseconds(25);
  /// Messages repeated to peers that never spoke, of all.
  static constexpr MonotonicTime kSilentPeriod = std::chrono::milliseconds(200);
  /// Handshake messages of all peers that cost public-key work.
  static constexpr int kMostMessages = 200;
  static constexpr MonotonicTime kMessagePeriod = std::chrono::microseconds(2500);
  /// So many messages of one peer count as few.
  static constexpr int kFewMessages = 12;
  static constexpr MonotonicTime kFewPeriod = std::chrono::milliseconds(250);
  /// Those of whom something was refused, or who send more than a few, have rations of their own.
  static constexpr MonotonicTime kLoudRequestPeriod = std::chrono::microseconds(1500);
  static constexpr MonotonicTime kLoudEchoPeriod = std::chrono::microseconds(1000);
  /// Messages that are repeated because something had to be dropped, of all peers.
  static constexpr int kMostNudges = 20;
  static constexpr MonotonicTime kNudgePeriod = std::chrono::milliseconds(20);
  /// Answers known by heart, of all peers.
  static constexpr MonotonicTime kRepetitionPeriod = std::chrono::milliseconds(2);
  /// Where unauthenticated participants are allowed, a peer whose handshake has not succeeded after
  /// so long is treated as one, and its handshake goes on: whatever anybody sends in its name makes
  /// this neither sooner nor final.
  static constexpr MonotonicTime kAdmissionPatience = std::chrono::seconds(3);
  /// A peer whose keys do not come for so long after its handshake is asked for another.
  static constexpr MonotonicTime kConfirmation = std::chrono::seconds(10);
  /// Where messages are not protected a peer without participant tokens has joined after so long,
  /// if the key exchange works: OpenDDS sends none there.
  static constexpr MonotonicTime kTokenPatience = std::chrono::seconds(1);
  /// Endpoints' tokens that are kept of a pair: those in use and revised ones.
  static constexpr std::size_t kMostEarlyOfPair = 2;
  /// Revised keys are in use so long after they were sent at the latest. Receivers let the former
  /// ones count twice as long.
  static constexpr MonotonicTime kRevisionPatience = std::chrono::seconds(5);
  /// When making revised keys failed.
  static constexpr MonotonicTime kRevisionRetry = std::chrono::seconds(1);
  /// Peers that left with our keys and whose trust is still watched; one more, and keys are
  /// revised.
  static constexpr std::size_t kMostAbsent = 256;
  /// How often a peer that asks again, as if it had forgotten us, is believed.
  static constexpr MonotonicTime kSecondHandshake = std::chrono::seconds(5);
  /// So long it may show that it has not, by keys of its own: what asks may be forged.
  static constexpr MonotonicTime kDoubt = std::chrono::seconds(2);

  /// Somebody runs `timers` whenever they say so, and tick whenever next_tick does.
  Security(std::unique_ptr<OwnSecurity> own, MessageSender& sender, TimerQueue& timers,
           SecurityHost& host, EventSink& events);
  ~Security();

  OwnSecurity& own() { return *own_; }
  const OwnSecurity& own() const { return *own_; }
  Keyring& keyring() { return keyring_; }
  const Keyring& keyring() const { return keyring_; }

  /// Registers the builtin endpoints. `own_data`: c.pdata, a big-endian parameter list.
  Status start(Bytes own_data);

  enum class Verdict { authenticate, admit_unauthenticated, refuse };
  /// What to do with a participant that announced itself; a refusal raises an event.
  Verdict judge(const ParticipantData& data);
  /// It says that it can, in the way that our governance wants.
  bool may_authenticate(const ParticipantData& data) const;
  /// Without authentication: only where nothing at all is protected.
  bool admits_unauthenticated() const;

  void discovered(const ParticipantData& data, const LocatorList& metatraffic, MonotonicTime now);
  /// Of a peer that is not authenticated something else was announced: perhaps what is right.
  void announced_again(const ParticipantData& data, const LocatorList& metatraffic,
                       MonotonicTime now);
  void lost(const GuidPrefix& peer);
  bool is_authenticated(const GuidPrefix& peer) const;
  /// It was discovered as one that authenticates, and was not lost since.
  bool knows(const GuidPrefix& peer) const { return peers_.contains(peer); }
  /// Its handshake has not come to an end, good or bad.
  bool is_authenticating(const GuidPrefix& peer) const;
  /// It sent a handshake message once: whoever only announces itself gives way to it.
  bool has_spoken(const GuidPrefix& peer) const;
  const AuthenticationCounters& authentication_counters() const { return counters_; }

  void on_stateless(const GuidPrefix& source, BytesView payload, MonotonicTime now);
  void on_stateless_frag(const GuidPrefix& source, const DataFrag& frag, MonotonicTime now);
  /// The volatile secure endpoints exist once for each peer; nullptr before authentication.
  StatefulWriter* volatile_writer(const GuidPrefix& peer);
  StatefulReader* volatile_reader(const GuidPrefix& peer);
  /// Something that only the peer can say came by the volatile secure channel.
  void note_key_exchange(const GuidPrefix& peer);

  /// The application does not trust it any longer. Before it is lost.
  void distrust(const GuidPrefix& peer);
  /// New keys for whoever is trusted now. Error: rtps_key_revision_disabled.
  Status revise_keys();

  void tick(MonotonicTime now);
  MonotonicTime next_tick() const;

  /// Brings a local and a remote endpoint together; true: they can be matched now, else on_keys
  /// says when.
  bool introduce(const EntityId& local, const Guid& remote, bool relay_only = false);

  /// May this remote endpoint match our one? `is_secure`: it was announced by secure SEDP.
  struct Endpoint {
    Guid guid;
    std::string_view topic;
    const std::vector<std::string>& partitions;
    const spi::PropertyList& data_tags;
    spi::SecurityInfo info;
    bool is_secure = false;
    std::optional<spi::CipherMask> required_ciphers = {};
  };
  struct Admission {
    bool relay_only = false;
  };
  /// Nothing: no, and an event says why.
  std::optional<Admission> admit(const EntityId& local, const Endpoint& remote);
  /// May we create this endpoint? Registers it. What discovery announces of it.
  struct NewEndpoint {
    std::string_view topic;
    const std::vector<std::string>& partitions;
    const spi::PropertyList& data_tags;
    const spi::PropertyList& properties;
  };
  struct Announced {
    std::optional<spi::SecurityInfo> info;
    std::optional<spi::CipherMask> required_ciphers;
    bool key_is_protected = false;
  };
  Result<Announced> create_endpoint(const EntityId& id, const NewEndpoint& endpoint);

 private:
  struct EarlyTokens {
    GenericMessage message;
    std::size_t octets;
  };
  struct Peer {
    ParticipantData data;
    LocatorList metatraffic;
    std::unique_ptr<PeerHandshake> handshake;
    spi::PermissionsHandle permissions = {};
    std::unique_ptr<StatefulWriter> volatile_writer = {};
    std::unique_ptr<StatefulReader> volatile_reader = {};
    std::vector<EarlyTokens> early = {};
    std::size_t early_octets = 0;
    bool established = false;     ///< handshake done, permissions good
    MonotonicTime since = {};     ///< of that
    unsigned generation = 0;      ///< which of its handshakes
    bool exchanges_keys = false;  ///< it showed that it has the secret
    bool authenticated = false;   ///< and its participant key is here, or none is needed
    bool refused = false;
    bool admitted = false;  ///< without authentication, until it succeeds
    bool spoke = false;
    bool failed = false;  ///< something of it was refused
    bool told_overdue = false;
    bool distrusted = false;
    WorkBudget few = {kFewMessages, kFewPeriod, {}};
    MonotonicTime next_second = {};        ///< handshake beside this one
    MonotonicTime doubted_until = kNever;  ///< it is said to have forgotten us
  };
  /// Left, and not because its trust ended: what it knows of our keys is still good.
  struct Absent {
    GuidPrefix prefix;
    std::unique_ptr<PeerHandshake> handshake;  ///< holds its identity
    spi::PermissionsHandle permissions;
  };
  /// Revised keys on their way to those who are trusted.
  struct Revision {
    spi::KeyRevision number;
    MonotonicTime deadline;
  };
  /// For those who behave, and for the loud.
  struct Ration {
    WorkBudget few, loud;
  };

  Status check_ciphers(VendorId vendor, spi::CipherMask required) const;
  Status check_participant(const ParticipantData& data) const;
  Status check_domain(const ParticipantData& proven) const;
  Status check_open(const EntityId& local, const Endpoint& remote) const;
  Status check_protection(const spi::EndpointSecurityAttributes& attributes, const Endpoint& remote,
                          VendorId vendor) const;
  Result<Admission> check_permissions(const EntityId& local, const Peer& peer,
                                      const Endpoint& remote);
  std::unique_ptr<PeerHandshake> handshake_with(const ParticipantData& data, MonotonicTime now);
  void send(Peer& peer, const PeerHandshake::Messages& messages);
  void on_auth_request(Peer& peer);
  void end_doubt(Peer& peer);
  void on_authentication(Peer& peer, const GenericMessage& message);
  bool may_spend(Peer& peer, Effort effort);
  void nudge(Peer& peer);
  /// True: the handshake has just succeeded, and the peer may join.
  bool advance(Peer& peer);
  Status establish(Peer& peer);
  void note_authenticated(Peer& peer);
  bool needs_no_tokens(const Peer& peer) const;
  Status adopt_proven_data(Peer& peer);
  void close(Peer& peer);
  void open_volatile(Peer& peer, MonotonicTime now);
  bool refuse(Peer& peer);
  void note_failure(Peer& peer);
  void note_overdue(Peer& peer);
  /// When it is to be admitted without authentication; never, if it is not.
  MonotonicTime next_admission(const Peer& peer) const;
  void admit_meanwhile(Peer& peer);
  void tick_handshake(Peer& peer, MonotonicTime now);
  void tick_handshakes();
  /// Its handshake may have something to do earlier than all did before.
  void look_after(const Peer& peer);
  void ask_over_volatile(Peer& peer);
  void send_volatile(Peer& peer, GenericMessage message);
  void send_tokens(Peer& peer, std::string_view message_class, const Guid& from, const Guid& to,
                   std::vector<spi::Token> tokens);
  void send_endpoint_tokens(Peer& peer, const EntityId& local, const Guid& remote,
                            std::vector<spi::Token> tokens);
  bool on_volatile(const GuidPrefix& prefix, const Change& change);
  void on_participant_tokens(Peer& peer, const GenericMessage& message);
  void on_endpoint_tokens(Peer& peer, GenericMessage message, std::size_t octets);
  static void drop_early(Peer& peer, std::vector<EarlyTokens>::iterator at);
  void apply_tokens(Peer& peer, const GenericMessage& message);
  void apply_early_tokens(Peer& peer, const EntityId& local, const Guid& remote, bool& ready);
  void expire();
  bool revises() const { return own_->attributes().is_key_revision_enabled; }
  void want_revision() { revision_due_ = revises(); }
  void tick_revision();
  void begin_revision();
  void finish_revision();
  void send_revised(Peer& peer);
  void send_revised(Peer& peer, const EntityId& local, const Guid& remote);
  /// It has our keys, and shall have the next.
  static bool is_trusted(const Peer& peer);
  bool has_revised(const Peer& peer) const;
  bool all_have_revised() const;
  MonotonicTime next_revision() const;
  void note_absent(Peer& peer);
  void forget_absent();
  void drop_absent(const GuidPrefix& prefix);
  void give_back(Absent& absent);
  Peer* find(const GuidPrefix& prefix);

  std::unique_ptr<OwnSecurity> own_;
  MessageSender& sender_;
  TimerQueue& timers_;
  SecurityHost& host_;
  EventSink& events_;
  Keyring keyring_;
  std::shared_ptr<const Bytes> own_data_;
  MessageNumbers numbers_;
  std::int64_t stateless_number_ = 0;
  std::int64_t volatile_number_ = 0;
  std::map<GuidPrefix, Peer> peers_;
  FragmentStore fragments_;
  AuthenticationCounters counters_;
  WorkBudget starts_{kMostStarts, kStartPeriod, {}};
  WorkBudget silent_{kMostStarts, kSilentPeriod, {}};
  WorkBudget spoken_starts_{kMostMessages, kMessagePeriod, {}};
  Ration requests_{{kMostMessages, kMessagePeriod, {}}, {kMostMessages, kLoudRequestPeriod, {}}};
  Ration echoes_{{kMostMessages, kMessagePeriod, {}}, {kMostMessages, kLoudEchoPeriod, {}}};
  WorkBudget repetitions_{kMostMessages, kRepetitionPeriod, {}};
  WorkBudget nudges_{kMostNudges, kNudgePeriod, {}};
  std::vector<Absent> absent_;
  bool revision_due_ = false;  ///< somebody lost its trust
  std::optional<Revision> revision_;
  MonotonicTime revision_retry_{};
  MonotonicTime now_{};
  MonotonicTime next_expiry_{};
  MonotonicTime next_handshake_ = kNever;  ///< none of them wants anything before
};

}  // namespace ddssec::rtps
