// DomainParticipant of DDS 1.4, 2.2.2.2.1, with its sockets and its thread. An application starts
// here.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/ids.hpp"
#include "base/plugin_services.hpp"
#include "base/result.hpp"
#include "rtps/dcps/builtin_topics.hpp"
#include "rtps/dcps/content_filtered_topic.hpp"
#include "rtps/dcps/publisher.hpp"
#include "rtps/dcps/subscriber.hpp"
#include "rtps/participant/participant_counters.hpp"
#include "rtps/security/security_counters.hpp"
#include "rtps/security/security_options.hpp"

namespace ddssec::rtps {

class ContextAccess;
class ParticipantService;
struct ParticipantParts;

/// The options with which a participant is created. Only domain_id usually needs a value.
struct DomainParticipantOptions {
  /// The DDS domain, 0 to 232; with security 0 to 230, because documents cannot name a higher one.
  DomainId domain_id = 0;
  /// Only participants with the same domain tag find each other.
  std::string domain_tag = {};
  /// Name and user data are announced by discovery. If the governance protects discovery, only
  /// authenticated participants receive them.
  std::string entity_name = {};
  Bytes user_data = {};
  /// Names or addresses of the network interfaces to use; {"lo"} stays on this machine. If this is
  /// empty, the participant uses every IPv4 interface that is up and supports multicast, or the
  /// loopback interface if there is none. The participant follows their changes while it runs
  /// (rtps_interfaces_changed).
  std::vector<std::string> interfaces = {};
  bool multicast = true;  ///< join 239.255.0.1 on each interface and announce to it
  /// IP addresses to which the participant announces itself by unicast, at the ports of participant
  /// indexes 0 to 9. The default reaches participants on this machine that use only the loopback
  /// interface.
  std::vector<std::string> peers = {"127.0.0.1"};
  /// Others remove this participant if they hear nothing of it for this long. As in all of DDS, a
  /// Duration has seconds and a fraction in units of 2^-32 s; Duration::from converts nanoseconds.
  Duration lease_duration{{10, 0}};
  /// Time between announcements of the participant, after the first few. If it is 0, it is derived
  /// from the lease duration.
  std::chrono::nanoseconds announcement_period{};
  /// Samples with a larger payload are sent in fragments of this size. In octets, 1 to
  /// kMaxFragment; other values count as the nearest of these.
  static constexpr std::uint32_t kMaxFragment = 14336;
  std::uint32_t fragment_size = kMaxFragment;
  /// Announces the TypeInformation of types generated from IDL. Cyclone DDS then does not match an
  /// endpoint whose type differs, even if only a bound differs.
  bool announce_types = true;
  /// Receive buffer to request from the operating system for each socket, in octets. If less is
  /// granted than large samples need, a warning event is raised.
  std::size_t receive_buffer = std::size_t{4} << 20;
  /// How long a thread looks for input again and again before it sleeps. This occupies a processor,
  /// but saves the time that a sleeping thread takes to wake up. At most kMaxBusyWait. The property
  /// org.ddssec.busy_wait of a secured participant takes precedence.
  std::chrono::nanoseconds busy_wait{};
  static constexpr std::chrono::nanoseconds kMaxBusyWait = std::chrono::milliseconds(1);
  bool own_thread = true;  ///< if false, the application calls poll()
  /// Delivers samples to participants of the same process directly, in the writer's thread, unless
  /// the topic is protected. If false, samples always go over the network.
  bool delivers_in_process = true;
  bool enabled = true;  ///< if false, it sends nothing until enable()
  /// Path of the file that stores the samples of writers with DURABILITY PERSISTENT. It is created
  /// if it does not exist. Only one participant at a time can use it, and no other user may be able
  /// to make files in its folder. If the path is empty, the samples last as long as the
  /// participant.
  std::string durability_store = {};
  /// Limit for the size of the store, in octets.
  std::size_t durability_store_octets = std::size_t{4} << 30;
  /// The security options; empty if the participant is not secured.
  std::optional<SecurityOptions> security = {};
};

/// DomainParticipantQos of DDS 1.4, 2.2.3.
struct DomainParticipantQos {
  Bytes user_data;  ///< announced by discovery
  /// ENTITY_FACTORY: topics, publishers and subscribers are created enabled.
  bool autoenable_created_entities = true;
  bool operator==(const DomainParticipantQos&) const = default;
};

/// Counters of the participant's protocol, which are never reset, and the number of remote
/// participants.
struct DomainParticipantCounters : ParticipantCounters {
  ProtectionCounters protection;          ///< what was dropped; all zero without security
  AuthenticationCounters authentication;  ///< all zero without security
  std::size_t remote_participants = 0;    ///< those that are known now
  /// Datagrams, timers and listeners that an exception ended (rtps_exception).
  std::uint64_t exceptions = 0;
};

namespace detail {
/// A separate base class, because it must be constructed before Entity, which needs its context.
struct ServiceHolder {
  ServiceHolder(const PluginServices& services, const DomainParticipantOptions& options);
  ~ServiceHolder();
  const std::unique_ptr<ParticipantService> service_;
};
}  // namespace detail

/// A participant of a DDS domain. Creates and deletes its topics, publishers and subscribers; those
/// that remain are deleted with it. All calls are thread-safe. Listeners are called by the
/// participant's thread, or by poll().
class DomainParticipant final : private detail::ServiceHolder, public Entity {
 public:
  /// Number of participant indexes at each address of DomainParticipantOptions::peers.
  static constexpr int kAnnouncedIndexes = 10;

  /// Creates a participant and raises the event rtps_joined, which names the interfaces. The clock,
  /// random source and event sink in `services` must outlive the participant.
  /// Errors: invalid_property (invalid domain, peer address or busy_wait), rtps_address_not_here
  /// (no such interface), rtps_port_taken (all participant indexes are in use), rtps_no_multicast
  /// (multicast fails and there are no peers), rtps_socket_failed, random_failed,
  /// rtps_thread_failed, rtps_store_unusable, rtps_store_failed; with security also those of the
  /// plugins.
  static Result<std::unique_ptr<DomainParticipant>> create(DomainParticipantOptions options,
                                                           const PluginServices& services);
  /// Waits until its listeners have returned. Must not be called from within one of them, nor from
  /// a listener of another participant that is being destroyed in a listener of this one: raises
  /// the event rtps_ended_in_listener and calls std::terminate.
  ~DomainParticipant() override;

  Guid guid() const { return guid_; }
  DomainId domain_id() const { return options_.domain_id; }
  /// Returns the participant index, which determines the ports (RTPS 9.6.2.3).
  int index() const;
  /// Returns a copy of the counters now.
  DomainParticipantCounters counters() const;
  /// Returns the calendar time that its samples get as source time (DDS 1.4, 2.2.2.2.1.26).
  Time current_time() const { return context_.moment().wall; }

  /// Returns the policies that are in force.
  DomainParticipantQos qos() const;
  /// Sets the policies. Changed user data is announced soon.
  void set_qos(const DomainParticipantQos& qos);
  /// Starts its thread and discovery, and enables what it contains unless
  /// autoenable_created_entities is false. Errors: rtps_thread_failed, those of the entities.
  Status enable() override;
  /// Replaces the listener, which the caller owns; nullptr removes it. `mask` has the statuses that
  /// it handles; the listeners of its entities are called first. Waits until running callbacks of
  /// the former listener have returned (exceptions: rtps/dcps/listener.hpp).
  void set_listener(DomainParticipantListener* listener, StatusMask mask = kAnyStatus);

  /// Creates a topic, which the participant owns. Errors: rtps_precondition_not_met (the name is
  /// already in use), rtps_qos_inconsistent, rtps_bad_parameter (the name of the topic or type is
  /// empty or longer than 256 characters). `qos`: default_topic_qos() if none is given. `listener`:
  /// see set_listener.
  template <DdsType T>
  Result<Topic*> create_topic(std::string name, std::optional<Qos> qos = {},
                              TopicListener* listener = nullptr, StatusMask mask = kAnyStatus) {
    return create_topic(std::move(name), type_support<T>(), std::move(qos), listener, mask);
  }
  /// As create_topic<T>, for a type that is described at run time, such as a topic of octets.
  Result<Topic*> create_topic(std::string name, TypeSupport type, std::optional<Qos> qos = {},
                              TopicListener* listener = nullptr, StatusMask mask = kAnyStatus);
  /// Returns nullptr if there is no topic with this name.
  Topic* lookup_topicdescription(std::string_view name) const;
  /// Creates a topic for readers that receive only the samples of `related` that pass the filter.
  /// Errors: rtps_filter_invalid, rtps_precondition_not_met (the name is already in use, or
  /// `related` belongs to another participant), rtps_bad_parameter (the name is empty or longer
  /// than 256 characters).
  Result<ContentFilteredTopic*> create_contentfilteredtopic(std::string name, Topic& related,
                                                            FilterText filter);
  /// Returns nullptr if there is no content-filtered topic with this name.
  ContentFilteredTopic* lookup_contentfilteredtopic(std::string_view name) const;
  /// Deletes the topic. Errors: rtps_precondition_not_met (the topic has readers or belongs to
  /// another participant, or the call is made from within a callback).
  Status delete_contentfilteredtopic(ContentFilteredTopic& topic);
  /// Creates a publisher, which the participant owns. The policies are checked when its first
  /// writer is created.
  Publisher& create_publisher(GroupQos qos = {}, PublisherListener* listener = nullptr,
                              StatusMask mask = kAnyStatus);
  /// Creates a subscriber, which the participant owns. The policies are checked when its first
  /// reader is created.
  Subscriber& create_subscriber(GroupQos qos = {}, SubscriberListener* listener = nullptr,
                                StatusMask mask = kAnyStatus);
  /// Deletes the topic. If find_topic has returned it as well, only the last of as many calls
  /// deletes it. Waits until running listeners of this participant have returned. Errors:
  /// rtps_precondition_not_met (the topic belongs to another participant or is in use, or the call
  /// is made from within a callback of this participant, or of another one that a callback of this
  /// one waits for).
  Status delete_topic(Topic& topic);
  /// Deletes a publisher without writers, or a subscriber without readers. Waits as delete_topic
  /// does. Errors: those of delete_topic; rtps_precondition_not_met also if it is not empty.
  Status delete_publisher(Publisher& publisher);
  Status delete_subscriber(Subscriber& subscriber);
  /// Deletes all topics, publishers and subscribers with what they contain. Pointers to them are
  /// invalid afterwards. Errors: rtps_precondition_not_met (called from within a callback, as for
  /// delete_topic).
  Status delete_contained_entities();
  /// True if it contains topics, publishers or subscribers, not counting builtin ones.
  bool contains_entities() const;
  /// Returns the policies of topics that are created without any.
  Qos default_topic_qos() const;
  /// Sets the policies of topics that are created without any. Errors: rtps_qos_inconsistent.
  Status set_default_topic_qos(const Qos& qos);

  /// Returns the subscriber whose readers deliver what discovery found as samples: DCPSParticipant,
  /// DCPSTopic, DCPSPublication and DCPSSubscription. This call creates all four readers, which
  /// cannot be deleted. Samples of entities that have ended stay until they are taken, within a
  /// limit for each identity (EndedInstances).
  Subscriber& builtin_subscriber();
  /// Returns the builtin reader of T: ParticipantBuiltinTopicData, TopicBuiltinTopicData,
  /// PublicationBuiltinTopicData or SubscriptionBuiltinTopicData. Creates this reader alone, if it
  /// does not exist yet. Returns nullptr once the application has deleted the subscriber's
  /// contained entities.
  template <class T>
  BuiltinDataReader<T>* builtin_datareader() {
    const std::lock_guard members(context_.members());
    auto& topics = BuiltinTopics::of(builtin_topics_, *this, context_);
    topics.template make<T>();
    return static_cast<BuiltinDataReader<T>*>(
        topics.subscriber().lookup_datareader(BuiltinTopicOf<T>::topic));
  }
  /// Returns the remote participants that were accepted. A secured participant accepts those that
  /// are authenticated, or admitted without authentication.
  std::vector<Guid> discovered_participants() const;
  /// Returns what a participant announced. Errors: rtps_bad_parameter (no such participant).
  Result<ParticipantBuiltinTopicData> discovered_participant_data(const Guid& participant) const;
  /// Returns the topics on which at least one remote endpoint is known.
  std::vector<TopicBuiltinTopicData> discovered_topics() const;
  /// Creates new keys and switches to them when all trusted peers have received them, after 5 s at
  /// the latest. Only for secured participants whose governance enables key revision. Key revision
  /// also happens automatically when a peer's identity or permissions end and when a peer is
  /// ignored (DDS-Security 1.2, clause 9.8.10.4). Call this for reasons that only the application
  /// knows. Errors: rtps_not_enabled, rtps_key_revision_disabled.
  Status revise_keys();
  /// Ignores the participant until this one is deleted, as if it had never been found (DDS 1.4,
  /// 2.2.2.2.1.14). With the participant's own GUID, its writers and readers do not match each
  /// other. A secured participant then revises its keys, if the governance enables that. Errors:
  /// rtps_not_enabled.
  Status ignore_participant(const Guid& participant);
  /// Ignores all remote writers and readers of that topic. Errors: rtps_not_enabled.
  Status ignore_topic(const std::string& name);
  /// Ignores a remote writer, or a remote reader. Errors: rtps_not_enabled.
  Status ignore_publication(const Guid& writer);
  Status ignore_subscription(const Guid& reader);
  /// Returns a topic of this participant. Otherwise waits up to `timeout` until a remote endpoint
  /// uses the name, and creates a topic of octets with the type that this endpoint announces. A
  /// topic must be deleted as often as it was created or found. Errors: rtps_timeout, those of
  /// create_topic.
  Result<Topic*> find_topic(const std::string& name, std::chrono::nanoseconds timeout);

  /// Asserts the liveliness of its writers with LIVELINESS MANUAL_BY_PARTICIPANT. Errors:
  /// rtps_not_enabled.
  Status assert_liveliness();

  /// Waits for datagrams and timers for at most `timeout`, and serves them and the listeners. Only
  /// for a participant without a thread of its own (own_thread = false).
  void poll(std::chrono::nanoseconds timeout);

 private:
  friend class AnyDataReader;
  friend class AnyDataWriter;
  friend class ContextAccess;
  friend class DomainParticipantFactory;
  friend class Topic;
  friend struct ParticipantParts;

  DomainParticipant(DomainParticipantOptions options, const PluginServices& services);
  const DomainParticipantOptions options_;
  DomainParticipantQos qos_;
  Qos default_topic_qos_;
  Guid guid_;
  ListenerAndMask<DomainParticipantListener> listening_;
  const std::unique_ptr<ParticipantParts> parts_;
  std::unique_ptr<BuiltinTopics> builtin_topics_;
};

}  // namespace ddssec::rtps
