// DomainParticipant, the half that is about what discovery found.
#include <algorithm>

#include "rtps/dcps/domain_participant.hpp"

namespace ddssec::rtps {

BuiltinTopics& DomainParticipant::builtin_topics() {
  const std::lock_guard members(context_.callbacks());
  if (!builtin_topics_) builtin_topics_ = std::make_unique<BuiltinTopics>(*this, context_);
  return *builtin_topics_;
}

std::vector<Guid> DomainParticipant::discovered_participants() const {
  const auto held = lock();
  std::vector<Guid> out;
  for (const auto& data : context_.protocol().remote_participants().participants())
    out.push_back(data.guid);
  return out;
}

Result<ParticipantBuiltinTopicData> DomainParticipant::discovered_participant_data(
    const Guid& participant) const {
  const auto held = lock();
  for (auto& data : context_.protocol().remote_participants().participants())
    if (data.guid == participant) return ParticipantBuiltinTopicData{std::move(data)};
  return fail(Code::rtps_bad_parameter,
              {.expected = "a discovered participant", .found = participant.to_string()});
}

std::vector<TopicBuiltinTopicData> DomainParticipant::discovered_topics() const {
  const auto held = lock();
  std::map<std::pair<std::string, std::string>, TopicBuiltinTopicData> found;
  for (auto& data : context_.protocol().remote_participants().endpoints())
    found.try_emplace({data.topic_name, data.type_name},
                      TopicBuiltinTopicData{data.topic_name, data.type_name, std::move(data.qos),
                                            has_key(data.guid.entity)});
  std::vector<TopicBuiltinTopicData> out;
  for (auto& [key, topic] : found) out.push_back(std::move(topic));
  return out;
}

template <class F>
Status DomainParticipant::ignore(F&& f) {
  const auto held = lock();
  DDSSEC_TRY(check_enabled("participant"));
  f(context_.protocol());
  context_.reschedule();
  return {};
}

Status DomainParticipant::revise_keys() {
  const auto held = lock();
  DDSSEC_TRY(check_enabled("participant"));
  const auto status = context_.protocol().revise_keys();
  context_.reschedule();
  return status;
}

Status DomainParticipant::ignore_participant(const Guid& participant) {
  return ignore([&](Participant& protocol) { protocol.ignore_participant(participant.prefix); });
}

Status DomainParticipant::ignore_topic(const std::string& name) {
  return ignore([&](Participant& protocol) { protocol.ignore_topic(name); });
}

Status DomainParticipant::ignore_publication(const Guid& writer) {
  return ignore([&](Participant& protocol) { protocol.ignore_endpoint(writer); });
}

Status DomainParticipant::ignore_subscription(const Guid& reader) {
  return ignore([&](Participant& protocol) { protocol.ignore_endpoint(reader); });
}

// DDS 1.4, 2.2.2.2.1.11: a topic of our own, or one of octets of the type that others use.
Result<Topic*> DomainParticipant::find_topic(const std::string& name,
                                             std::chrono::nanoseconds most) {
  const auto find_own = [&] {
    const auto at = std::ranges::find(topics_, name, [](const auto& t) { return t->name(); });
    return at == topics_.end() ? nullptr : at->get();
  };
  std::optional<EndpointData> remote;
  {
    auto held = lock();
    Topic* own = nullptr;
    const bool found = context_.wait(held, most, [&] {
      own = find_own();
      remote = context_.protocol().endpoint_on(name);
      return own != nullptr || remote;
    });
    if (!found) return fail(Code::rtps_timeout, {.document = "topic " + name});
    if (own != nullptr) {
      ++own->references_;
      return own;
    }
  }
  return create_topic(name, {.name = remote->type_name, .with_key = has_key(remote->guid.entity)});
}

}  // namespace ddssec::rtps
