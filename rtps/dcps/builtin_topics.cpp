#include "rtps/dcps/builtin_topics.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/hash.hpp"
#include "rtps/dcps/domain_participant.hpp"
#include "rtps/discovery/serialized.hpp"
#include "rtps/participant/rtps_participant.hpp"

namespace ddssec::rtps {
namespace {

template <class Data>
Payload payload_of(const Data& data) {
  return Payload::copy_of(serialized(data));
}

KeyHash topic_key(const EndpointData& data) {
  const auto text = data.topic_name + '\0' + data.type_name;
  const auto digest = sha256(as_bytes(text));
  KeyHash out;
  std::ranges::copy_n(digest.begin(), out.size(), out.begin());
  return out;
}

Result<EndpointData> read_endpoint(BytesView payload) {
  auto data = read_publication_data(payload);
  return data ? data : read_subscription_data(payload);
}

// A disposed instance is reduced to its GUID.
Result<Guid> key_of(BytesView octets) {
  if (octets.size() != Guid::size) return fail(Code::truncated);
  return Guid::from(octets);
}

template <class T>
Result<T> by_key(BytesView octets) {
  T out;
  DDSSEC_ASSIGN_OR_RETURN(out.guid, key_of(octets));
  return out;
}

// Returns the policies of builtin readers (DDS 1.4, 2.2.5).
Qos builtin_reader_qos() {
  auto qos = default_reader_qos();
  qos.reliability.kind = ReliabilityKind::reliable;
  qos.durability = DurabilityKind::transient_local;
  return qos;
}

}  // namespace

Result<ParticipantBuiltinTopicData> BuiltinTopicOf<ParticipantBuiltinTopicData>::read(
    BytesView payload, bool is_key_only) {
  if (is_key_only) return by_key<ParticipantBuiltinTopicData>(payload);
  DDSSEC_ASSIGN_OR_RETURN(auto participant_data, read_participant_data(payload));
  return ParticipantBuiltinTopicData{std::move(participant_data)};
}

Result<TopicBuiltinTopicData> BuiltinTopicOf<TopicBuiltinTopicData>::read(BytesView payload, bool) {
  DDSSEC_ASSIGN_OR_RETURN(auto data, read_endpoint(payload));
  return TopicBuiltinTopicData{std::move(data.topic_name), std::move(data.type_name),
                               std::move(data.qos), has_key(data.guid.entity)};
}

Result<PublicationBuiltinTopicData> BuiltinTopicOf<PublicationBuiltinTopicData>::read(
    BytesView payload, bool is_key_only) {
  if (is_key_only) return by_key<PublicationBuiltinTopicData>(payload);
  DDSSEC_ASSIGN_OR_RETURN(auto publication_data, read_publication_data(payload));
  return PublicationBuiltinTopicData{std::move(publication_data)};
}

Result<SubscriptionBuiltinTopicData> BuiltinTopicOf<SubscriptionBuiltinTopicData>::read(
    BytesView payload, bool is_key_only) {
  if (is_key_only) return by_key<SubscriptionBuiltinTopicData>(payload);
  DDSSEC_ASSIGN_OR_RETURN(auto subscription_data, read_subscription_data(payload));
  return SubscriptionBuiltinTopicData{std::move(subscription_data)};
}

BuiltinTopics::BuiltinTopics(DomainParticipant& participant, ParticipantContext& context)
    : participant_(participant), context_(context) {
  GroupQos qos;
  qos.presentation.scope = PresentationScope::topic;
  subscriber_.reset(new Subscriber(participant_, context_, qos));
  // This fails if the participant is not enabled yet. The participant's enable() then enables the
  // subscriber.
  [[maybe_unused]] const auto enabled = subscriber_->enable();
}

BuiltinTopics& BuiltinTopics::of(std::unique_ptr<BuiltinTopics>& made,
                                 DomainParticipant& participant, ParticipantContext& context) {
  if (!made) made = std::make_unique<BuiltinTopics>(participant, context);
  return *made;
}

BuiltinTopics::~BuiltinTopics() {
  const std::lock_guard lock(context_.mutex());
  context_.protocol().set_discovery_listener(nullptr);
}

// The caller ensures that only one thread creates readers.
template <class T>
void BuiltinTopics::make() {
  {
    const std::lock_guard lock(context_.mutex());
    if (readers_.contains(BuiltinTopicOf<T>::topic)) return;
  }
  create<T>();
  const std::lock_guard lock(context_.mutex());
  only_ = BuiltinTopicOf<T>::topic;
  readers_.try_emplace(only_);
  context_.protocol().set_discovery_listener(this);
  only_ = {};
}
template void BuiltinTopics::make<ParticipantBuiltinTopicData>();
template void BuiltinTopics::make<TopicBuiltinTopicData>();
template void BuiltinTopics::make<PublicationBuiltinTopicData>();
template void BuiltinTopics::make<SubscriptionBuiltinTopicData>();

template <class T>
void BuiltinTopics::create() {
  const std::string name(BuiltinTopicOf<T>::topic);
  TypeSupport type{.name = name + "BuiltinTopicData"};
  // A topic has no GUID, so its whole data is its key.
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

AnyDataReader* BuiltinTopics::reader_of(std::string_view topic) const {
  if (!readers_.contains(topic) || (!only_.empty() && topic != only_)) return nullptr;
  for (const auto& member : subscriber_->members_)
    if (member->topic().name() == topic) return static_cast<AnyDataReader*>(member.get());
  return nullptr;
}

void BuiltinTopics::deliver(const BuiltinChange& what, Payload payload) {
  auto* reader = reader_of(what.topic);
  if (reader == nullptr) return;
  Change change;
  change.payload = std::move(payload);
  readers_[what.topic].ended.remove(what.key);
  offer(*reader, what, std::move(change));
}

// If the reader had no room for the entity, there is no end to report.
void BuiltinTopics::deliver_end(const BuiltinChange& what, const GuidPrefix& by) {
  auto* reader = reader_of(what.topic);
  if (reader == nullptr || reader->reception_.cache().lookup(what.key).is_nil()) return;
  Change change;
  change.status = {true, true};
  change.is_key_only = true;
  const auto octets = reader->reception_.cache().octets_of(what.key);
  offer(*reader, what, std::move(change));
  reader->reception_.forget_ended(
      readers_[what.topic].ended.add(what.key, identity_of(by), octets));
}

// If there is no room, instances that have ended are removed to make room for those that exist.
void BuiltinTopics::offer(AnyDataReader& reader, const BuiltinChange& what, Change change) {
  change.writer = what.of;
  change.key_hash = what.key;
  change.source_time = context_.moment().wall;
  auto& told = readers_[what.topic];
  bool taken = reader.on_change(change);
  if (!taken) {
    reader.reception_.forget_ended(told.ended.take_all());
    taken = reader.on_change(change);
  }
  if (std::exchange(told.is_refused, !taken) || taken) return;
  const auto& cache = reader.reception_.cache();
  context_.services().events.raise(
      Event(Error(Code::rtps_too_many_endpoints,
                  {.document = fmt::format("builtin topic {}", what.topic),
                   .expected = "room in its reader",
                   .found = fmt::format("{} instances of {} octets that the application has not "
                                        "taken",
                                        cache.held().all().size(), cache.held().octets())})));
}

// A participant's identity is remembered, because its removal is reported after its keys are gone.
GuidPrefix BuiltinTopics::identity_of(const GuidPrefix& participant) const {
  const auto known = identities_.find(participant);
  return known == identities_.end() ? participant : known->second;
}

void BuiltinTopics::on_participant(const ParticipantData& data) {
  const auto& prefix = data.guid.prefix;
  identities_[prefix] = context_.protocol().remote_participants().core().identity_of(prefix);
  deliver({"DCPSParticipant", data.guid.octets(), data.guid}, payload_of(data));
}

void BuiltinTopics::on_participant_gone(const Guid& guid) {
  deliver_end({"DCPSParticipant", guid.octets(), guid}, guid.prefix);
  identities_.erase(guid.prefix);
}

void BuiltinTopics::on_endpoint(const EndpointData& data) {
  const auto topic = is_writer(data.guid.entity) ? "DCPSPublication" : "DCPSSubscription";
  deliver({topic, data.guid.octets(), data.guid}, payload_of(data));
  count_topic(data, 1);
}

void BuiltinTopics::on_endpoint_gone(const EndpointData& data) {
  const auto topic = is_writer(data.guid.entity) ? "DCPSPublication" : "DCPSSubscription";
  deliver_end({topic, data.guid.octets(), data.guid}, data.guid.prefix);
  count_topic(data, -1);
}

// A topic exists while a remote participant has an endpoint on it.
void BuiltinTopics::count_topic(const EndpointData& data, int by) {
  constexpr std::string_view kTopic = "DCPSTopic";
  if (!readers_.contains(kTopic)) return;
  const auto key = topic_key(data);
  if (by > 0) {
    if (topic_of_.try_emplace(data.guid, key).second && ++endpoints_of_[key] == 1)
      deliver({kTopic, key, {}}, payload_of(data));
    return;
  }
  if (topic_of_.erase(data.guid) == 0 || --endpoints_of_[key] > 0) return;
  endpoints_of_.erase(key);
  deliver_end({kTopic, key, {}}, data.guid.prefix);
}

}  // namespace ddssec::rtps
