#include "rtps/dcps/discovered_entities.hpp"

#include "rtps/participant/rtps_participant.hpp"

namespace ddssec::rtps {

std::vector<Guid> DiscoveredEntities::participants() const {
  const std::lock_guard held(context_.mutex());
  std::vector<Guid> out;
  for (const auto& data : context_.protocol().remote_participants().participants())
    out.push_back(data.guid);
  return out;
}

Result<ParticipantBuiltinTopicData> DiscoveredEntities::participant_data(
    const Guid& participant) const {
  const std::lock_guard held(context_.mutex());
  for (auto& data : context_.protocol().remote_participants().participants())
    if (data.guid == participant) return ParticipantBuiltinTopicData{std::move(data)};
  return fail(Code::rtps_bad_parameter,
              {.expected = "a discovered participant", .found = participant.to_string()});
}

std::vector<TopicBuiltinTopicData> DiscoveredEntities::topics() const {
  const std::lock_guard held(context_.mutex());
  std::map<std::pair<std::string, std::string>, TopicBuiltinTopicData> found;
  for (auto& data : context_.protocol().remote_participants().endpoints())
    found.try_emplace({data.topic_name, data.type_name},
                      TopicBuiltinTopicData{data.topic_name, data.type_name, std::move(data.qos),
                                            has_key(data.guid.entity)});
  std::vector<TopicBuiltinTopicData> out;
  for (auto& [key, topic] : found) out.push_back(std::move(topic));
  return out;
}

Status DiscoveredEntities::change(const std::function<void(RtpsParticipant&)>& f) {
  const std::lock_guard held(context_.mutex());
  DDSSEC_RETURN_IF_ERROR(check_());
  f(context_.protocol());
  context_.reschedule();
  return {};
}

Status DiscoveredEntities::ignore_participant(const Guid& participant) {
  return change(
      [&](RtpsParticipant& protocol) { protocol.ignore_participant(participant.prefix); });
}

Status DiscoveredEntities::ignore_topic(const std::string& name) {
  return change([&](RtpsParticipant& protocol) { protocol.ignore_topic(name); });
}

Status DiscoveredEntities::ignore_endpoint(const Guid& endpoint) {
  return change([&](RtpsParticipant& protocol) { protocol.ignore_endpoint(endpoint); });
}

}  // namespace ddssec::rtps
