// The builtin topics and their subscriber (DDS 1.4, 2.2.5): what discovery found, as samples.
#pragma once

#include "rtps/dcps/ended_instances.hpp"
#include "rtps/dcps/subscriber.hpp"
#include "rtps/discovery/discovery_listener.hpp"

namespace ddssec::rtps {

// The keys are the GUIDs; what a disposed one was is told by its key alone.
struct ParticipantBuiltinTopicData : ParticipantData {};
struct PublicationBuiltinTopicData : EndpointData {};
struct SubscriptionBuiltinTopicData : EndpointData {};
/// A topic of which a remote writer or reader was found; not one's own.
struct TopicBuiltinTopicData {
  std::string name = {};
  std::string type_name = {};
  Qos qos = {};  ///< as the first endpoint that was found has it
  bool with_key = true;
};

/// How each of them is told: its topic, its reader, its payload.
template <class T>
struct BuiltinTopicOf;
template <>
struct BuiltinTopicOf<ParticipantBuiltinTopicData> {
  static constexpr std::string_view topic = "DCPSParticipant";
  static constexpr EntityId reader = kSpdpReader;
  static Result<ParticipantBuiltinTopicData> read(BytesView payload, bool key_only);
};
template <>
struct BuiltinTopicOf<TopicBuiltinTopicData> {
  static constexpr std::string_view topic = "DCPSTopic";
  static constexpr EntityId reader{{0x00, 0x00, 0x02, 0xc7}};
  static Result<TopicBuiltinTopicData> read(BytesView payload, bool key_only);
};
template <>
struct BuiltinTopicOf<PublicationBuiltinTopicData> {
  static constexpr std::string_view topic = "DCPSPublication";
  static constexpr EntityId reader = kPublicationsReader;
  static Result<PublicationBuiltinTopicData> read(BytesView payload, bool key_only);
};
template <>
struct BuiltinTopicOf<SubscriptionBuiltinTopicData> {
  static constexpr std::string_view topic = "DCPSSubscription";
  static constexpr EntityId reader = kSubscriptionsReader;
  static Result<SubscriptionBuiltinTopicData> read(BytesView payload, bool key_only);
};

template <class T>
struct BuiltinSample {
  T data;
  SampleInfo info;
};

/// A reader of a builtin topic: reliable, transient-local, KEEP_LAST 1. Lives with its participant.
template <class T>
class BuiltinDataReader final
    : public AnyDataReader,
      public SampleAccess<BuiltinDataReader<T>, std::vector<BuiltinSample<T>>> {
 private:
  friend class Group;
  friend class SampleAccess<BuiltinDataReader<T>, std::vector<BuiltinSample<T>>>;
  using AnyDataReader::AnyDataReader;

  Result<Guid> create(EndpointRequest) override {
    return Guid{context_.protocol().prefix(), BuiltinTopicOf<T>::reader};
  }
  Status check_unused() const override {
    return precondition_not_met("reader", "one that was created", "a builtin one");
  }
  Result<std::size_t> fill(const Query& query, std::vector<BuiltinSample<T>>& out) {
    std::vector<OctetSample> raw;
    out.clear();
    if (auto found = access(query, raw); !found) return found;
    for (const auto& sample : raw)
      if (auto data = BuiltinTopicOf<T>::read(sample.payload.view(), sample.key_only))
        out.push_back({std::move(*data), sample.info});
      else
        count_malformed();
    return out.size();
  }
};

/// Each reader is made when it is first asked for, and costs nothing before: what no application
/// takes from it stays. Of what has ended, a bounded part stays (EndedInstances).
class BuiltinTopics final : private DiscoveryListener {
 public:
  BuiltinTopics(DomainParticipant& participant, ParticipantContext& context);
  /// Made if it was not yet; with the lock of callbacks.
  static BuiltinTopics& of(std::unique_ptr<BuiltinTopics>& made, DomainParticipant& participant,
                           ParticipantContext& context);
  ~BuiltinTopics() override;

  Subscriber& subscriber() { return *subscriber_; }
  /// Makes that reader, once, and tells it what is known.
  template <class T>
  void make();

 private:
  void on_participant(const ParticipantData& data) override;
  void on_participant_gone(const Guid& guid) override;
  void on_endpoint(const EndpointData& data) override;
  void on_endpoint_gone(const EndpointData& data) override;

  struct Told {
    EndedInstances ended = {};
    bool refused = false;  ///< it has no room, and an event said so
  };
  /// What a reader is told. `of`: of no endpoint, if it is a topic.
  struct News {
    std::string_view topic;
    KeyHash key;
    Guid of;
  };
  template <class T>
  void create();
  /// nullptr: no application asked for it, it is not meant, or it is deleted.
  AnyDataReader* reader_of(std::string_view topic) const;
  void deliver(const News& news, Payload payload);
  void deliver_end(const News& news, const GuidPrefix& by);
  /// Says so if it has no room.
  void give(AnyDataReader& reader, const News& news, Change change);
  void count_topic(const EndpointData& data, int by);
  GuidPrefix identity_of(const GuidPrefix& participant) const;

  DomainParticipant& participant_;
  ParticipantContext& context_;
  std::vector<std::unique_ptr<Topic>> topics_;
  std::unique_ptr<Subscriber> subscriber_;
  std::map<std::string_view, Told> told_;        ///< by topic
  std::string_view only_;                        ///< while this one is told what is known
  std::map<GuidPrefix, GuidPrefix> identities_;  ///< of participants, also while they go
  std::map<Guid, KeyHash> topic_of_;
  std::map<KeyHash, int> endpoints_of_;
};

}  // namespace ddssec::rtps
