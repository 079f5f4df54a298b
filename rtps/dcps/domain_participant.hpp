// DomainParticipant of DDS 1.4, 2.2.2.2.1, with its sockets and its thread: where applications
// begin.
#pragma once

#include "rtps/dcps/discovered_entities.hpp"
#include "rtps/dcps/groups.hpp"
#include "rtps/dcps/participant_service.hpp"
#include "rtps/dcps/topic_descriptions.hpp"
#include "rtps/durability/durable_stores.hpp"

namespace ddssec::rtps {

struct DomainParticipantOptions {
  DomainId domain_id = 0;
  std::string domain_tag = {};
  std::string entity_name = {};
  Bytes user_data = {};
  /// Names or addresses of the interfaces to use, {"lo"} to stay on this machine. Without any:
  /// every IPv4 interface that is up and does multicast, or the loopback if there is none.
  std::vector<std::string> interfaces = {};
  bool multicast = true;  ///< announce to and listen at 239.255.0.1 on each of them
  /// Addresses that are announced to by unicast, at the ports of participant indexes 0 to 9: by
  /// default those participants of this machine that use its loopback alone.
  std::vector<std::string> peers = {"127.0.0.1"};
  Duration lease_duration{{10, 0}};
  /// Between announcements of the participant, after the first few; 0: as the lease wants it.
  std::chrono::nanoseconds announcement_period{};
  /// Samples above this many octets go in fragments of it; 14336 at most.
  std::uint32_t fragment_size = MessageSender::kLargestFragment;
  /// TypeInformation of types made from IDL is announced. Cyclone DDS then matches no endpoint
  /// whose type is another one, be it in a bound alone.
  bool announce_types = true;
  /// Octets to ask the system for, for each socket; a warning if it grants less than large samples
  /// need.
  std::size_t receive_buffer = UdpSocket::kWantedBuffer;
  bool own_thread = true;  ///< false: the application calls poll()
  /// Samples for participants of this process go there directly, in the writer's thread, unless
  /// the topic is protected; false: always by the network.
  bool in_process = true;
  bool enabled = true;  ///< false: silent until enable()
  /// The file in which samples of writers with DURABILITY PERSISTENT are kept; made if it is
  /// missing, and for one participant at a time. Empty: they last as long as the participant.
  std::string durability_store = {};
  std::size_t durability_store_octets = SampleStore::kDefaultOctets;
  /// Nothing: not a secured participant.
  std::optional<SecurityOptions> security = {};
};

struct DomainParticipantQos {
  Bytes user_data;
  bool autoenable_created_entities = true;
  bool operator==(const DomainParticipantQos&) const = default;
};

/// What its protocol has counted, never reset, and how many others there are.
struct DomainParticipantCounters : ParticipantCounters {
  ProtectionCounters protection;          ///< what was dropped; all zero without security
  AuthenticationCounters authentication;  ///< all zero without security
  std::size_t remote_participants = 0;    ///< those that are known now
};

namespace detail {
/// Stands before Entity, which needs the context in it.
struct ServiceHolder {
  ServiceHolder(const Environment& environment, const DomainParticipantOptions& options)
      : service_(environment, options.own_thread,
                 options.in_process ? Neighbourhood::of(options.domain_id, options.domain_tag)
                                    : std::make_shared<Neighbourhood>()) {}
  ParticipantService service_;
};
}  // namespace detail

/// Makes and deletes its topics, publishers and subscribers; what is left of them dies with it. All
/// calls are thread-safe. Listeners are called by the participant's thread (or by poll).
class DomainParticipant final : private detail::ServiceHolder, public Entity {
 public:
  static constexpr int kAnnouncedIndexes = 10;

  /// Raises rtps_joined, which names the interfaces. Errors: invalid_property (no such domain or
  /// address), rtps_address_not_here (no such interface), rtps_port_taken (all indexes),
  /// rtps_no_multicast (and no peers), rtps_socket_failed, random_failed, rtps_store_unusable,
  /// rtps_store_failed.
  static Result<std::unique_ptr<DomainParticipant>> create(DomainParticipantOptions options,
                                                           const Environment& environment);
  ~DomainParticipant() override;

  Guid guid() const { return guid_; }
  DomainId domain_id() const { return options_.domain_id; }
  int index() const { return service_.sockets().index(); }
  DomainParticipantCounters counters() const;
  Time current_time() const { return context_.moment().wall; }

  DomainParticipantQos qos() const;
  Status set_qos(const DomainParticipantQos& qos);
  Status enable() override;
  void set_listener(DomainParticipantListener* listener, StatusMask mask = kAnyStatus);

  /// Errors: rtps_precondition_not_met (there is a topic of this name), rtps_qos_inconsistent,
  /// rtps_bad_parameter (a name that is empty or longer than 256).
  template <DdsType T>
  Result<Topic*> create_topic(std::string name, std::optional<Qos> qos = {},
                              TopicListener* listener = nullptr, StatusMask mask = kAnyStatus) {
    return create_topic(std::move(name), type_support<T>(), std::move(qos), listener, mask);
  }
  Result<Topic*> create_topic(std::string name, TypeSupport type, std::optional<Qos> qos = {},
                              TopicListener* listener = nullptr, StatusMask mask = kAnyStatus);
  /// nullptr if there is none.
  Topic* lookup_topicdescription(std::string_view name) const { return topics_.lookup(name); }
  /// For readers of `related` that want only what passes the filter. Errors: rtps_filter_invalid,
  /// and those of create_topic.
  Result<ContentFilteredTopic*> create_contentfilteredtopic(std::string name, Topic& related,
                                                            FilterText filter) {
    return topics_.create_filtered(std::move(name), related, std::move(filter));
  }
  /// nullptr if there is none.
  ContentFilteredTopic* lookup_contentfilteredtopic(std::string_view name) const {
    return topics_.lookup_filtered(name);
  }
  /// Errors: rtps_precondition_not_met (it has readers, or is another participant's).
  Status delete_contentfilteredtopic(ContentFilteredTopic& topic) { return topics_.remove(topic); }
  /// Errors: rtps_qos_inconsistent.
  Result<Publisher*> create_publisher(GroupQos qos = {}, PublisherListener* listener = nullptr,
                                      StatusMask mask = kAnyStatus) {
    return groups_.create_publisher(std::move(qos), listener, mask);
  }
  Result<Subscriber*> create_subscriber(GroupQos qos = {}, SubscriberListener* listener = nullptr,
                                        StatusMask mask = kAnyStatus) {
    return groups_.create_subscriber(std::move(qos), listener, mask);
  }
  // Errors: rtps_precondition_not_met (another participant's, one that is used or not empty, or
  // from within a callback).
  Status delete_topic(Topic& topic) { return topics_.remove(topic); }
  Status delete_publisher(Publisher& publisher) { return groups_.remove(publisher); }
  Status delete_subscriber(Subscriber& subscriber) { return groups_.remove(subscriber); }
  Status delete_contained_entities();
  bool contains_entities() const;
  Qos default_topic_qos() const;
  /// Errors: rtps_qos_inconsistent.
  Status set_default_topic_qos(const Qos& qos);

  /// What discovery found, as samples: readers of DCPSParticipant, DCPSTopic, DCPSPublication and
  /// DCPSSubscription. This call makes all four, and they cannot be deleted. The samples of
  /// entities that have ended stay until they are taken, within a bound for each identity
  /// (EndedInstances).
  Subscriber& builtin_subscriber();
  /// Its reader of ParticipantBuiltinTopicData, TopicBuiltinTopicData, PublicationBuiltinTopicData
  /// or SubscriptionBuiltinTopicData, which alone is made now, if it was not before; nullptr once
  /// the application has deleted it with the rest.
  template <class T>
  BuiltinDataReader<T>* builtin_datareader() {
    const std::lock_guard members(context_.callbacks());
    auto& topics = BuiltinTopics::of(builtin_topics_, *this, context_);
    topics.template make<T>();
    return static_cast<BuiltinDataReader<T>*>(
        topics.subscriber().lookup_datareader(BuiltinTopicOf<T>::topic));
  }
  /// Those that were accepted: if this participant is secured, authenticated or admitted without.
  std::vector<Guid> discovered_participants() const { return discovered_.participants(); }
  /// Errors: rtps_bad_parameter (none of them).
  Result<ParticipantBuiltinTopicData> discovered_participant_data(const Guid& participant) const {
    return discovered_.participant_data(participant);
  }
  /// Topics of which a remote endpoint is known.
  std::vector<TopicBuiltinTopicData> discovered_topics() const { return discovered_.topics(); }
  /// Secured participants of a domain whose governance enables it: makes new keys and puts them to
  /// use once all trusted peers have them, after 5 s at the latest. Happens by itself when a peer's
  /// identity or permissions end and when one is ignored (DDS-Security 1.2 9.8.10.4); this is for
  /// what only the application knows. Errors: rtps_not_enabled, rtps_key_revision_disabled.
  Status revise_keys();
  // For good, and as if it had never been found. Errors: rtps_not_enabled.
  /// Our own GUID: our writers and readers do not match each other.
  Status ignore_participant(const Guid& participant) {
    return discovered_.ignore_participant(participant);
  }
  Status ignore_topic(const std::string& name) { return discovered_.ignore_topic(name); }
  Status ignore_publication(const Guid& writer) { return discovered_.ignore_endpoint(writer); }
  Status ignore_subscription(const Guid& reader) { return discovered_.ignore_endpoint(reader); }
  /// A topic of this participant, or a new one of octets with the type that others announce for
  /// that name, as soon as there is one. To be deleted as often as it was created or found.
  /// Errors: rtps_timeout, those of create_topic.
  Result<Topic*> find_topic(const std::string& name, std::chrono::nanoseconds most) {
    return topics_.find(name, most);
  }

  /// Asserts its writers with LIVELINESS MANUAL_BY_PARTICIPANT. Errors: rtps_not_enabled.
  Status assert_liveliness();

  /// Serves sockets, timers and listeners for at most `timeout`; only without a thread of its own.
  void poll(std::chrono::nanoseconds timeout) { service_.serve(timeout); }

 private:
  friend class AnyDataReader;
  friend class AnyDataWriter;
  friend class Keeper;
  friend class Topic;

  DomainParticipant(DomainParticipantOptions options, const Environment& environment);
  const DomainParticipantOptions options_;
  DomainParticipantQos qos_;
  Qos default_topic_qos_;
  Guid guid_;
  Listening<DomainParticipantListener> listening_;
  DurableStores stores_;
  ManualLiveliness manual_liveliness_;
  DiscoveredEntities discovered_;
  TopicDescriptions topics_;
  Groups groups_;  // refer to topics
  std::unique_ptr<BuiltinTopics> builtin_topics_;
};

}  // namespace ddssec::rtps
