// The protocol side of a participant: SPDP, SEDP, endpoints and their matching (RTPS 8.5). It is
// told of datagrams and of time and sends through a transport; no socket, clock, thread or lock.
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <set>

#include "base/event.hpp"
#include "rtps/discovery/discovery_listener.hpp"
#include "rtps/discovery/participant_data.hpp"
#include "rtps/participant/builtin_endpoints.hpp"
#include "rtps/participant/message_receiver.hpp"
#include "rtps/participant/neighbourhood.hpp"
#include "rtps/qos/matching.hpp"
#include "rtps/reliability/stateful_reader.hpp"
#include "rtps/security/security.hpp"
#include "rtps/transport/interfaces.hpp"
#include "wire/entity_ids.hpp"

namespace ddssec::rtps {

/// What a local endpoint's owner is told. Called from within receive, tick, create and remove.
class EndpointListener {
 public:
  virtual ~EndpointListener() = default;
  /// Again for a remote that is matched already, when it announced changed policies.
  virtual void on_matched(const EndpointData& remote) = 0;
  virtual void on_unmatched(const Guid& remote) = 0;
  virtual void on_incompatible_qos(const Guid& remote, const QosMismatch& mismatch) = 0;
  /// The same topic name with another type, or with keys on one side only.
  virtual void on_inconsistent_topic(const EndpointData& remote) = 0;
  /// A reader's: takes the change or refuses it for now (see StatefulReader::Deliver).
  virtual bool on_change(Change& change) = 0;
  /// A reader's: so many changes of a writer will never come.
  virtual void on_sample_lost(std::int64_t count) = 0;
  /// A reader's: a change of so many octets was given up, as it is larger than readers take.
  virtual void on_sample_dropped(const Guid&, std::uint32_t) { on_sample_lost(1); }
  /// A reader's: the matched writer showed, in the way of its LIVELINESS.kind, that it lives. Only
  /// for writers that offer a finite lease_duration.
  virtual void on_alive(const Guid& writer) = 0;
  /// A reader's: the writer has nothing undelivered up to that group sequence number.
  virtual void on_group(const Guid&, SequenceNumber) {}
  /// A writer's: there may be room again.
  virtual void on_acknowledged() = 0;
  /// Its payloads are encrypted, and with them its keys (DDS-Security 7.4.4). Said before anything
  /// else.
  virtual void on_key_protected() {}
  /// A writer's: what keeps a matching reader's samples from being sent to it; nullptr: nothing.
  /// Asked before on_matched, and again whenever the reader announces itself anew.
  virtual std::shared_ptr<ChangeFilter> filter_for(const EndpointData&) { return nullptr; }
};

struct ParticipantConfig {
  GuidPrefix prefix;
  DomainId domain_id = 0;
  std::string domain_tag = {};
  std::string entity_name = {};
  Bytes user_data = {};
  Duration lease_duration{{10, 0}};
  LocatorList metatraffic_unicast = {}, metatraffic_multicast = {}, default_unicast = {};
  /// Of this machine, that lead to others; without any, all addresses of others are taken to do so.
  std::vector<NetworkInterface> interfaces = {};
  /// Where announcements go: multicast groups and the well-known ports of unicast peers.
  std::vector<Locator> announce_to = {};
  /// Of announcements, after the first few, which come quickly; 0: as the lease wants it.
  std::chrono::nanoseconds announcement_period{};
  std::uint32_t fragment_size = MessageSender::kLargestFragment;
  /// Whose members are spoken to without the network where nothing is protected. The caller enters
  /// the participant, and calls it with the neighbourhood's lock held.
  std::shared_ptr<Neighbourhood> neighbourhood = {};
};

/// The few of `announced` that one can and may send to, the nearest (keep_nearest); without any,
/// `fallback`.
LocatorList usable_locators(const LocatorList& announced, const LocatorList& fallback,
                            std::span<const NetworkInterface> own);
/// When a participant that was heard at `now` counts as gone.
MonotonicTime lease_end(const ParticipantData& data, MonotonicTime now);

class Participant final : private SecurityHost, private EndpointLookup, private MessageListener {
 public:
  static constexpr std::size_t kMostParticipants = 512;
  static constexpr std::size_t kMostEndpointsPerParticipant = 16384;
  static constexpr std::size_t kMostEndpoints = 65536;  ///< of all of them
  /// What their announcements take in memory, with a price for each.
  static constexpr std::size_t kMostEndpointOctetsPerParticipant = std::size_t{64} << 20;
  static constexpr std::size_t kMostEndpointOctets = std::size_t{256} << 20;
  static constexpr std::size_t kPricePerEndpoint = 1024;
  /// So much of each participant is kept whatever the others announce.
  static constexpr std::size_t kEndpointOctetsOfEach = std::size_t{256} << 10;
  /// Announcements that are answered, to addresses that anybody may have named.
  static constexpr int kMostAnswers = 100;
  static constexpr MonotonicTime kAnswerPeriod = std::chrono::milliseconds(10);
  /// Between two announcements, when there are more to answer.
  static constexpr MonotonicTime kHurry = std::chrono::milliseconds(250);
  /// Of a peer that authenticates, whatever is announced in its name.
  static constexpr MonotonicTime kLeastLease = std::chrono::seconds(10);
  /// How long a peer that only a clear message says has left must keep silent to be believed gone:
  /// longer than Fast DDS between two announcements.
  static constexpr MonotonicTime kDoubt = std::chrono::seconds(4);
  /// Where messages are protected, another participant may be able to read what we say only some
  /// time after we can read it, and what a volatile writer sends meanwhile is lost to its reader.
  /// So a reliable reader counts as matched when it is heard, or after so long.
  static constexpr MonotonicTime kReadiness = std::chrono::seconds(1);
  static constexpr unsigned kMostBacklog = 16;  ///< batches that are read before anything is due

  Participant(ParticipantConfig config, Transport& transport, EventSink& events);
  ~Participant() override;

  /// Makes it a secured one, before anything else happens; the prefix must be that of `own`.
  /// Errors: those of the plugins.
  Status secure(std::unique_ptr<OwnSecurity> own);

  const GuidPrefix& prefix() const { return config_.prefix; }
  const ParticipantCounters& counters() const { return counters_; }
  /// All zero without security.
  ProtectionCounters protection_counters() const {
    return security_ ? security_->keyring().counters() : ProtectionCounters{};
  }
  AuthenticationCounters authentication_counters() const {
    return security_ ? security_->authentication_counters() : AuthenticationCounters{};
  }
  bool is_authenticated(const GuidPrefix& peer) const {
    return security_ && security_->is_authenticated(peer);
  }
  /// Samples may wait a moment for others, as somebody calls tick whenever next_tick says so.
  void allow_lingering() { sender_.allow_lingering(); }
  std::size_t remote_participants() const { return remotes_.size(); }

  /// While it lives, what is to be sent waits for its end and shares messages.
  MessageSender::Gathering gather() { return MessageSender::Gathering(sender_); }
  /// One datagram, from anybody.
  void receive(BytesView datagram, MonotonicTime now);
  /// Told after each batch of datagrams: more wait to be received. The answers to what we would
  /// repeat may be among them, so nothing is due before they are read, or many batches of them.
  void note_backlog(bool any) {
    backlog_ = any ? backlog_ + 1 : 0;
    reads_first_ = backlog_ % kMostBacklog != 0;
  }
  /// Whatever is due: announcements, heartbeats, leases.
  void tick(MonotonicTime now);
  MonotonicTime next_tick() const;
  /// Says good-bye: disposes the participant.
  void leave();

  /// What is announced of a new endpoint. Errors: rtps_qos_inconsistent, and if it is secured those
  /// of access control.
  struct EndpointRequest {
    std::string topic_name;
    std::string type_name;
    Qos qos;
    bool with_key = true;
    TypeDescription type = {};
    std::optional<ContentFilterProperty> content_filter = {};  ///< a reader's
    std::vector<Change> history = {};  ///< a writer's, from before: only for who asks for history
    bool history_only = false;         ///< a writer's: see StatefulWriter::serve_history_only
    std::optional<Guid> group = {};    ///< of a publisher with GROUP access
    KeyRewriter bare_key = {};         ///< a writer's: see StatefulWriter::rewrite_keys_with
  };
  Result<Guid> create_writer(EndpointRequest request, EndpointListener& listener,
                             MonotonicTime now);
  Result<Guid> create_reader(EndpointRequest request, EndpointListener& listener,
                             MonotonicTime now);
  /// Also tells the others.
  void remove(const Guid& endpoint, MonotonicTime now);

  /// Announces other policies of an endpoint of ours and matches it anew. Which ones may change is
  /// the caller's business. Errors: rtps_qos_inconsistent.
  Status change_qos(const Guid& endpoint, Qos qos, MonotonicTime now);
  /// Announces another content filter of a reader of ours.
  void change_filter(const Guid& reader, ContentFilterProperty filter, MonotonicTime now);
  /// Announces other user data of the participant, soon.
  void change_user_data(Bytes user_data) {
    config_.user_data = std::move(user_data);
    next_announcement_ = {};
    announce_securely(false);
  }
  /// Tells `listener`, from now on and what is known already; nullptr: nobody.
  void listen(DiscoveryListener* listener);
  /// Those that were accepted (see DiscoveryListener).
  std::vector<ParticipantData> known_participants() const;
  std::vector<EndpointData> known_endpoints() const;
  /// Any remote endpoint on that topic.
  std::optional<EndpointData> endpoint_on(const std::string& topic_name) const;
  /// For good: as if it had never been found. Our own prefix: our endpoints ignore each other.
  void ignore_participant(const GuidPrefix& prefix);
  /// See Security.
  Status revise_keys();
  void ignore_endpoint(const Guid& guid);
  void ignore_topic(const std::string& name);
  /// Remote endpoints that match one of ours.
  std::vector<Guid> matched(const Guid& endpoint) const;
  /// What an endpoint, remote or our own, announced; nullptr if it is not known (any more). Of our
  /// own those are known that have a counterpart here.
  const EndpointData* remote_endpoint(const Guid& guid);

  /// Tells all that our writers of this kind live (RTPS 8.4.13). Those of kind AUTOMATIC are
  /// asserted by tick.
  void assert_liveliness(LivelinessKind kind, MonotonicTime now);

  /// A name for a publisher.
  Guid create_group();
  /// nullptr: not one of ours.
  StatefulWriter* writer(const Guid& guid);
  StatefulReader* reader(const Guid& guid);

 private:
  struct LocalWriter {
    EndpointData data;
    EndpointListener* listener = nullptr;
    std::unique_ptr<StatefulWriter> protocol;
    std::vector<Guid> matched;
    std::vector<Guid> unready = {};  ///< matched, and its owner does not know yet (see Readiness)
  };
  /// Of a reader that has not shown yet that it has matched our writer.
  struct Readiness {
    Guid writer, reader;
    MonotonicTime deadline;
  };
  struct LocalReader {
    EndpointData data;
    EndpointListener* listener = nullptr;
    std::unique_ptr<StatefulReader> protocol;
    std::vector<Guid> matched;
  };
  /// A local reader that wants to know whether a remote writer lives.
  struct Watch {
    EndpointListener* listener;
    Guid writer;
    LivelinessKind kind;
  };
  struct RemoteEndpoint {
    EndpointData data;
    std::vector<StatefulReader*> readers = {};  ///< of ours, that a writer matched
    std::size_t price = 0;
  };
  /// Who can match at all; nobody else is looked at.
  struct TopicEnds {
    std::vector<LocalWriter*> writers;
    std::vector<LocalReader*> readers;
    std::vector<Guid> remotes;
    bool empty() const { return writers.empty() && readers.empty() && remotes.empty(); }
  };
  struct Remote {
    ParticipantData data;
    LocatorList metatraffic, user;
    MonotonicTime lease_end{};
    MonotonicTime since{};
    std::map<EntityId, RemoteEndpoint> endpoints = {};
    std::vector<Watch> watches = {};  ///< only where a lease is finite
    bool accepted = false;            ///< authenticated, or admitted without
    bool heard_participants_secure = false;
    std::size_t endpoint_octets = 0;  ///< their price
    bool exceeds = false;             ///< there were more, which was said
  };
  // EndpointLookup
  std::span<StatefulReader* const> readers_of(const Guid& writer) override;
  StatefulWriter* writer_for(const EntityId& writer, const GuidPrefix& reader) override;
  // MessageListener
  Status on_announcement(const GuidPrefix& source, const Data& data) override;
  void on_stateless(const GuidPrefix& source, BytesView payload) override;
  void on_stateless_frag(const GuidPrefix& source, const DataFrag& frag) override;
  void on_builtin_heartbeat(const Guid& writer) override;
  void on_alive(const Guid& writer) override { note_alive(writer.prefix, writer.entity); }
  void on_acknack(const EntityId& writer, const Guid& reader) override;
  void on_key_exchange(const GuidPrefix& source) override;
  void on_message(const GuidPrefix& source, bool is_protected) override;

  LocalWriter* local_writer(const EntityId& id);

  ParticipantData own_data() const;
  void announce(std::span<const Locator> to);
  void announce(const ParticipantData& own, std::span<const Locator> to, std::size_t interface);
  MonotonicTime announcement_period() const;
  void announce_securely(bool leaving);
  void add_remote(ParticipantData data, MonotonicTime now);
  bool make_room();
  std::map<GuidPrefix, Remote>::iterator oldest_unproven();
  void on_known(Remote& remote, ParticipantData data, MonotonicTime now);
  void on_dispose(const GuidPrefix& prefix);
  void renew_lease(Remote& remote, const ParticipantData& data, MonotonicTime now);
  void match_builtin(Remote& remote);
  void accept(Remote& remote);
  void tell_of(const Remote& remote);
  bool is_ignored(const EndpointData& data) const;
  void match_builtin(const BuiltinTopicInfo& info, Remote& remote, bool writer);
  void note_participants_secure(const GuidPrefix& peer);
  void unmatch(Remote& remote);
  void remove_remote(const GuidPrefix& prefix);

  void publish(const EndpointData& data, MonotonicTime now);
  void unpublish(const Guid& endpoint, MonotonicTime now);
  bool is_announced_securely(const EntityId& endpoint) const;
  StatefulWriter& sedp_writer(const EntityId& endpoint);
  bool on_builtin(BuiltinTopic topic, const Change& change);
  void on_sedp(const Change& change, bool publications, bool secure);
  void on_participant_message(const Change& change, bool secure);
  void on_secure_participant(const Change& change);
  void add_endpoint(Remote& remote, EndpointData data);
  bool has_room(Remote& remote, const RemoteEndpoint* known, std::size_t price);
  void remove_endpoint(Remote& remote, const EntityId& id);
  void match(LocalWriter& writer, Remote& remote, const EndpointData& data);
  void match(LocalReader& reader, Remote& remote, const EndpointData& data);
  bool shows_readiness(const LocalWriter& writer, const EndpointData& reader) const;
  void note_ready(LocalWriter& writer, const Guid& reader);
  void tick_readiness(MonotonicTime now);
  bool is_open(const EntityId& endpoint) const;
  /// The participant of this process that may be called directly for this pair, or nullptr.
  Participant* neighbour(const EntityId& local, const Guid& remote);
  /// The pair is fed directly, once both sides have matched, if it may be.
  void join(const Guid& local, const Guid& remote);
  void meet(LocalWriter& writer, LocalReader& reader);
  /// Our endpoint is about to end.
  template <class Local>
  void part_from(const std::vector<Local*>& others, const Guid& endpoint);
  // SecurityHost
  void on_authenticated(const GuidPrefix& peer) override;
  void on_refused(const GuidPrefix& peer) override;
  LocatorList on_proven(const GuidPrefix& peer, const ParticipantData& proven) override;
  void on_replaced(const GuidPrefix& peer) override;
  void on_keys(const EntityId& local, const Guid& remote) override;
  void on_early_keys(const Guid& remote) override;
  void on_ended(const GuidPrefix& peer) override;

  /// See Keyring; nothing without security.
  std::optional<Sha256Digest> keys_of(const EntityId& local, const Guid& remote) const {
    return security_ ? security_->keyring().keys_of(local, remote) : std::nullopt;
  }
  /// False: security keeps them apart, or their keys are not here yet.
  bool introduce(const EntityId& local, const EndpointData& remote, bool& keep);
  template <class Local>
  bool compatible(Local& local, const EndpointData& remote, const Qos& offered,
                  const Qos& requested);
  template <class Local>
  void forget(Local& local, const Guid& remote);
  template <class Local>
  void match_all(Local& local);
  RemoteEndpoint* find_remote(const Guid& guid);
  template <class Local>
  void take_off(Local& local, std::vector<Local*> TopicEnds::*where);
  void forget_if_empty(const std::string& topic_name);
  void remove_ended(MonotonicTime now);
  /// `remote` asserted the liveliness of all its writers of this kind: AUTOMATIC ones by any
  /// message, MANUAL_BY_PARTICIPANT ones by a sample of any of them or a ParticipantMessage.
  void note_alive(const Remote& remote, LivelinessKind kind);
  /// This writer asserted itself, by a sample or a heartbeat that says so.
  void note_alive(const GuidPrefix& from, const EntityId& writer);
  void expect_liveliness_of(const Liveliness& liveliness, MonotonicTime now);
  EndpointData local_data(EndpointRequest request, EndpointKind kind);
  Status secure_endpoint(EndpointData& data, EndpointListener& listener);

  ParticipantConfig config_;
  EventSink& events_;
  MessageSender sender_;
  TimerQueue timers_;
  ParticipantCounters counters_;
  std::map<GuidPrefix, Remote> remotes_;
  struct {
    std::set<GuidPrefix> participants;
    std::set<Guid> endpoints;
    std::set<std::string> topics;
  } ignored_;
  DiscoveryListener* discovery_ = nullptr;
  Remote self_;  ///< ourselves, as the other end of our own endpoints
  std::map<EntityId, LocalWriter> writers_;
  std::map<EntityId, LocalReader> readers_;
  std::map<std::string, TopicEnds> topics_;
  std::size_t remote_endpoints_ = 0;
  std::size_t endpoint_octets_ = 0;  ///< their price
  BuiltinEndpoints builtin_;
  std::unique_ptr<Security> security_;
  MessageReceiver receiver_;
  StatefulReader* volatile_reader_ = nullptr;  ///< of the peer that was looked up last
  WorkBudget answers_{kMostAnswers, kAnswerPeriod, {}};
  /// In the order of their announcements; some have spoken since, or left.
  std::deque<GuidPrefix> silent_;
  std::vector<GuidPrefix> gone_;  ///< to be removed when nothing of theirs is being read any more
  std::deque<Readiness> readiness_;  ///< by their deadlines
  MonotonicTime next_liveliness_ = kNever;
  MonotonicTime next_lease_ = kNever;  ///< no lease ends before
  std::uint32_t next_entity_ = 1;
  static constexpr MonotonicTime kFastPeriod = std::chrono::milliseconds(100);
  static constexpr MonotonicTime kRepeatDelay = std::chrono::milliseconds(500);
  int announcements_ = 0;
  MonotonicTime next_announcement_{}, last_announcement_{};
  MonotonicTime now_{};
  unsigned backlog_ = 0;      ///< batches since there was none
  bool reads_first_ = false;  ///< before the next tick counts
};

}  // namespace ddssec::rtps
