#include "rtps/dcps/builtin_topics.hpp"

#include <array>

#include "base/hash.hpp"
#include "rtps/dcps/domain_participant.hpp"

namespace ddssec::rtps {
namespace {

template <class Data>
Payload payload_of(const Data& data) {
  std::array<std::uint8_t, MessageSender::kLargestMessage> buffer;
  SpanWriter out(buffer);
  write_payload(out, data);
  return Payload::copy_of(out.view());
}

KeyHash topic_key(const EndpointData& data) {
  const auto text = data.topic_name + '\0' + data.type_name;
  return md5(as_bytes(text));
}

Result<EndpointData> read_endpoint(BytesView payload) {
  auto data = read_publication_data(payload);
  return data ? data : read_subscription_data(payload);
}

// All that is left of a disposed one is its GUID.
Result<Guid> key_of(BytesView octets) {
  if (octets.size() != 16) return fail(Code::truncated);
  return Guid{GuidPrefix::from(octets.first(12)), EntityId::from(octets.subspan(12))};
}

template <class T>
Result<T> by_key(BytesView octets) {
  T out;
  out.guid = DDSSEC_TRY(key_of(octets));
  return out;
}

// DDS 1.4, 2.2.5.
Qos builtin_reader_qos() {
  auto qos = default_reader_qos();
  qos.reliability.kind = ReliabilityKind::reliable;
  qos.durability = DurabilityKind::transient_local;
  return qos;
}

}  // namespace

Result<ParticipantBuiltinTopicData> BuiltinTopicOf<ParticipantBuiltinTopicData>::read(
    BytesView payload, bool key_only) {
  if (key_only) return by_key<ParticipantBuiltinTopicData>(payload);
  return ParticipantBuiltinTopicData{DDSSEC_TRY(read_participant_data(payload))};
}

Result<TopicBuiltinTopicData> BuiltinTopicOf<TopicBuiltinTopicData>::read(BytesView payload, bool) {
  auto data = DDSSEC_TRY(read_endpoint(payload));
  return TopicBuiltinTopicData{std::move(data.topic_name), std::move(data.type_name),
                               std::move(data.qos), has_key(data.guid.entity)};
}

Result<PublicationBuiltinTopicData> BuiltinTopicOf<PublicationBuiltinTopicData>::read(
    BytesView payload, bool key_only) {
  if (key_only) return by_key<PublicationBuiltinTopicData>(payload);
  return PublicationBuiltinTopicData{DDSSEC_TRY(read_publication_data(payload))};
}

Result<SubscriptionBuiltinTopicData> BuiltinTopicOf<SubscriptionBuiltinTopicData>::read(
    BytesView payload, bool key_only) {
  if (key_only) return by_key<SubscriptionBuiltinTopicData>(payload);
  return SubscriptionBuiltinTopicData{DDSSEC_TRY(read_subscription_data(payload))};
}

BuiltinTopics::BuiltinTopics(DomainParticipant& participant, ParticipantContext& context)
    : participant_(participant), context_(context) {
  GroupQos qos;
  qos.presentation.scope = PresentationScope::topic;
  subscriber_.reset(new Subscriber(participant_, context_, qos));
  add<ParticipantBuiltinTopicData>();
  add<TopicBuiltinTopicData>();
  add<PublicationBuiltinTopicData>();
  add<SubscriptionBuiltinTopicData>();
  [[maybe_unused]] const auto enabled = subscriber_->enable();  // or with the participant
  const std::lock_guard lock(context_.mutex());
  context_.protocol().listen(this);
}

BuiltinTopics::~BuiltinTopics() {
  const std::lock_guard lock(context_.mutex());
  context_.protocol().listen(nullptr);
}

template <class T>
void BuiltinTopics::add() {
  const std::string name(BuiltinTopicOf<T>::topic);
  TypeSupport type{.name = name + "BuiltinTopicData"};
  // What a topic was can only be told by all of it.
  type.serialized_key = [](const Change& change) {
    const auto payload = change.payload.view();
    if constexpr (std::is_same_v<T, TopicBuiltinTopicData>)
      return Bytes(payload.begin(), payload.end());
    else
      return Bytes(change.key_hash->begin(), change.key_hash->end());
  };
  topics_.emplace_back(new Topic(participant_, context_, name, std::move(type), {}));
  auto& topic = *topics_.back();
  [[maybe_unused]] const auto made = subscriber_->create<BuiltinDataReader<T>>(
      topic, topic.type_name(), builtin_reader_qos(), static_cast<DataReaderListener*>(nullptr),
      kAnyStatus);
}

void BuiltinTopics::deliver(std::string_view topic, const KeyHash& key, const Guid& of,
                            Payload payload) {
  Change change;
  change.writer = of;
  change.key_hash = key;
  change.source_time = context_.moment().wall;
  const bool ends = payload.size() == 0;
  change.status = {ends, ends};
  change.key_only = ends;
  change.payload = std::move(payload);
  for (auto& member : subscriber_->members_)
    if (member->topic().name() == topic) {
      static_cast<AnyDataReader&>(*member).on_change(change);
      return;
    }
}

void BuiltinTopics::on_participant(const ParticipantData& data) {
  deliver("DCPSParticipant", data.guid.octets(), data.guid, payload_of(data));
}

void BuiltinTopics::on_participant_gone(const Guid& guid) {
  deliver("DCPSParticipant", guid.octets(), guid, {});
}

void BuiltinTopics::on_endpoint(const EndpointData& data) {
  const auto topic = is_writer(data.guid.entity) ? "DCPSPublication" : "DCPSSubscription";
  deliver(topic, data.guid.octets(), data.guid, payload_of(data));
  count_topic(data, 1);
}

void BuiltinTopics::on_endpoint_gone(const EndpointData& data) {
  const auto topic = is_writer(data.guid.entity) ? "DCPSPublication" : "DCPSSubscription";
  deliver(topic, data.guid.octets(), data.guid, {});
  count_topic(data, -1);
}

// A topic is there while anybody has an endpoint on it.
void BuiltinTopics::count_topic(const EndpointData& data, int by) {
  const auto key = topic_key(data);
  const Guid nobody;
  if (by > 0) {
    if (topic_of_.try_emplace(data.guid, key).second && ++endpoints_of_[key] == 1)
      deliver("DCPSTopic", key, nobody, payload_of(data));
    return;
  }
  if (topic_of_.erase(data.guid) == 0 || --endpoints_of_[key] > 0) return;
  endpoints_of_.erase(key);
  deliver("DCPSTopic", key, nobody, {});
}

}  // namespace ddssec::rtps
