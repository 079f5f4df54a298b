// The builtin topics and their subscriber (DDS 1.4, 2.2.5), which deliver what discovery found as
// samples.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "rtps/dcps/ended_instances.hpp"
#include "rtps/dcps/subscriber.hpp"
#include "rtps/discovery/discovery_listener.hpp"
#include "wire/entity_ids.hpp"

namespace ddssec::rtps {

/// A remote participant. The key is its GUID. For a disposed instance only the key is available.
struct ParticipantBuiltinTopicData : ParticipantData {};
/// A remote writer. The key is its GUID, as above.
struct PublicationBuiltinTopicData : EndpointData {};
/// A remote reader. The key is its GUID, as above.
struct SubscriptionBuiltinTopicData : EndpointData {};
/// A topic on which a remote writer or reader was found. The participant's own topics are not
/// reported.
struct TopicBuiltinTopicData {
  std::string name = {};
  std::string type_name = {};
  Qos qos = {};  ///< the policies of the first endpoint that was found
  bool with_key = true;
};

/// Describes each builtin topic: its name, its reader's entity id and how its payload is
/// deserialized. `read` takes a payload with its encapsulation; with `is_key_only`, the payload is
/// the key alone. It is for BuiltinDataReader. Errors: rtps_parameter_invalid and the other codes
/// of malformed announcements.
template <class T>
struct BuiltinTopicOf;
template <>
struct BuiltinTopicOf<ParticipantBuiltinTopicData> {
  static constexpr std::string_view topic = "DCPSParticipant";
  static constexpr EntityId reader = kSpdpReader;
  /// Reads a payload as BuiltinTopicOf describes.
  static Result<ParticipantBuiltinTopicData> read(BytesView payload, bool is_key_only);
};
template <>
struct BuiltinTopicOf<TopicBuiltinTopicData> {
  static constexpr std::string_view topic = "DCPSTopic";
  static constexpr EntityId reader = kTopicsReader;
  /// Reads a payload as BuiltinTopicOf describes.
  static Result<TopicBuiltinTopicData> read(BytesView payload, bool is_key_only);
};
template <>
struct BuiltinTopicOf<PublicationBuiltinTopicData> {
  static constexpr std::string_view topic = "DCPSPublication";
  static constexpr EntityId reader = kPublicationsReader;
  /// Reads a payload as BuiltinTopicOf describes.
  static Result<PublicationBuiltinTopicData> read(BytesView payload, bool is_key_only);
};
template <>
struct BuiltinTopicOf<SubscriptionBuiltinTopicData> {
  static constexpr std::string_view topic = "DCPSSubscription";
  static constexpr EntityId reader = kSubscriptionsReader;
  /// Reads a payload as BuiltinTopicOf describes.
  static Result<SubscriptionBuiltinTopicData> read(BytesView payload, bool is_key_only);
};

/// A sample that a builtin reader returns.
template <class T>
struct BuiltinSample {
  T data;  ///< only its key is meaningful if !info.valid_data
  SampleInfo info;
};

/// A reader of a builtin topic: RELIABLE, TRANSIENT_LOCAL, KEEP_LAST 1. Deleted with its
/// participant.
template <class T>
class BuiltinDataReader final
    : public AnyDataReader,
      public SampleAccess<BuiltinDataReader<T>, std::vector<BuiltinSample<T>>> {
 private:
  friend class Group;
  friend class SampleAccess<BuiltinDataReader<T>, std::vector<BuiltinSample<T>>>;
  using AnyDataReader::AnyDataReader;

  Result<Guid> create(EndpointDescription) override {
    return Guid{context_.prefix(), BuiltinTopicOf<T>::reader};
  }
  Status check_unused() const override {
    return precondition_not_met_error("reader", "one that was created", "a builtin one");
  }
  Result<std::size_t> fill(const SampleQuery& query, std::vector<BuiltinSample<T>>& out) {
    std::vector<OctetSample> raw;
    out.clear();
    if (auto found = access(query, raw); !found) return found;
    for (const auto& sample : raw)
      if (auto data = BuiltinTopicOf<T>::read(sample.payload.view(), sample.is_key_only))
        out.push_back({std::move(*data), sample.info});
      else
        count_malformed();
    return out.size();
  }
};

/// The builtin readers of a participant. Each reader is created when it is first requested; before
/// that it costs nothing. Samples that no application takes stay in the reader. For entities that
/// have ended, their number is limited (EndedInstances).
class BuiltinTopics final : private DiscoveryListener {
 public:
  /// Both must outlive this object.
  BuiltinTopics(DomainParticipant& participant, ParticipantContext& context);
  /// Returns the object, and creates it if needed. The caller holds the callback lock.
  static BuiltinTopics& of(std::unique_ptr<BuiltinTopics>& made, DomainParticipant& participant,
                           ParticipantContext& context);
  ~BuiltinTopics() override;

  /// See DomainParticipant::builtin_subscriber. Owned by this object.
  Subscriber& subscriber() { return *subscriber_; }
  /// Creates the reader of T once, and delivers what is already known.
  template <class T>
  void make();

 private:
  void on_participant(const ParticipantData& data) override;
  void on_participant_gone(const Guid& guid) override;
  void on_endpoint(const EndpointData& data) override;
  void on_endpoint_gone(const EndpointData& data) override;

  struct ReaderState {
    EndedInstances ended = {};
    bool is_refused = false;  ///< the reader had no room, and an event reported it
  };
  /// A change that is delivered to a reader. `of` is the endpoint or participant; zero for a topic.
  struct BuiltinChange {
    std::string_view topic;
    KeyHash key;
    Guid of;
  };
  template <class T>
  void create();
  /// Returns nullptr if no application requested the reader, if only another reader is to receive
  /// what is known, or if the reader is deleted.
  AnyDataReader* reader_of(std::string_view topic) const;
  void deliver(const BuiltinChange& what, Payload payload);
  void deliver_end(const BuiltinChange& what, const GuidPrefix& by);
  /// Raises an event if the reader has no room.
  void offer(AnyDataReader& reader, const BuiltinChange& what, Change change);
  void count_topic(const EndpointData& data, int by);
  GuidPrefix identity_of(const GuidPrefix& participant) const;

  DomainParticipant& participant_;
  ParticipantContext& context_;
  std::vector<std::unique_ptr<Topic>> topics_;
  std::unique_ptr<Subscriber> subscriber_;
  std::map<std::string_view, ReaderState> readers_;  ///< by topic
  std::string_view only_;  ///< the only topic that receives data while what is known is delivered
  /// The identities of participants. Each is kept until the removal of its participant is
  /// delivered.
  std::map<GuidPrefix, GuidPrefix> identities_;
  std::map<Guid, KeyHash> topic_of_;
  std::map<KeyHash, int> endpoints_of_;
};

}  // namespace ddssec::rtps
