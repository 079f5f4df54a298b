// Participant, the part that shows what discovery found, and ignores what it is told to ignore
// (DDS 1.4, 2.2.2.2.1.14 to 2.2.2.2.1.17).
#include "rtps/participant/participant.hpp"

namespace ddssec::rtps {

void Participant::listen(DiscoveryListener* listener) {
  discovery_ = listener;
  if (discovery_ == nullptr) return;
  for (const auto& [prefix, remote] : remotes_) {
    if (remote.accepted) discovery_->on_participant(remote.data);
    for (const auto& [id, endpoint] : remote.endpoints) discovery_->on_endpoint(endpoint.data);
  }
}

void Participant::accept(Remote& remote) {
  if (!std::exchange(remote.accepted, true)) tell_of(remote);
}

void Participant::tell_of(const Remote& remote) {
  if (remote.accepted && discovery_ != nullptr) discovery_->on_participant(remote.data);
}

std::vector<ParticipantData> Participant::known_participants() const {
  std::vector<ParticipantData> out;
  for (const auto& [prefix, remote] : remotes_)
    if (remote.accepted) out.push_back(remote.data);
  return out;
}

std::vector<EndpointData> Participant::known_endpoints() const {
  std::vector<EndpointData> out;
  for (const auto& [prefix, remote] : remotes_)
    for (const auto& [id, endpoint] : remote.endpoints) out.push_back(endpoint.data);
  return out;
}

void Participant::ignore_participant(const GuidPrefix& prefix) {
  if (!ignored_.participants.insert(prefix).second) return;
  if (security_) security_->distrust(prefix);
  if (prefix != config_.prefix) return remove_remote(prefix);
  for (auto& [id, writer] : writers_)
    for (auto& [other, reader] : readers_) meet(writer, reader);
}

void Participant::ignore_endpoint(const Guid& guid) {
  if (!ignored_.endpoints.insert(guid).second) return;
  if (const auto at = remotes_.find(guid.prefix); at != remotes_.end())
    remove_endpoint(at->second, guid.entity);
  if (const auto at = writers_.find(guid.entity);
      guid.prefix == config_.prefix && at != writers_.end())
    match_all(at->second);
  if (const auto at = readers_.find(guid.entity);
      guid.prefix == config_.prefix && at != readers_.end())
    match_all(at->second);
}

void Participant::ignore_topic(const std::string& name) {
  if (!ignored_.topics.insert(name).second) return;
  const auto at = topics_.find(name);
  if (at == topics_.end()) return;
  for (const auto& guid : std::vector(at->second.remotes))
    remove_endpoint(remotes_.find(guid.prefix)->second, guid.entity);
  for (auto& [id, writer] : writers_)
    if (writer.data.topic_name == name) match_all(writer);
}

bool Participant::is_ignored(const EndpointData& data) const {
  return ignored_.participants.contains(data.guid.prefix) ||
         ignored_.endpoints.contains(data.guid) || ignored_.topics.contains(data.topic_name);
}

}  // namespace ddssec::rtps
