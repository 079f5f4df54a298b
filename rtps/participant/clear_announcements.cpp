#include "rtps/participant/clear_announcements.hpp"

namespace ddssec::rtps {

void ClearAnnouncements::give_way(RemoteParticipant& remote, const EndpointData& secure) {
  const auto id = secure.guid.entity;
  const auto known = remote.endpoints.find(id);
  if (known != remote.endpoints.end() && !known->second.data.by_secure_discovery)
    matcher_.remove(remote, id);
  if (remotes_.has_room(remote, secure)) return;
  std::vector<EntityId> clear;
  for (const auto& [other, endpoint] : remote.endpoints)
    if (!endpoint.data.by_secure_discovery) clear.push_back(other);
  for (const auto& other : clear) matcher_.remove(remote, other);
}

bool ClearAnnouncements::note_announced(RemoteParticipant& remote, const EndpointData& endpoint) {
  const auto known = remote.endpoints.find(endpoint.guid.entity);
  if (known == remote.endpoints.end() ||
      !is_doubtful(remote, endpoint.guid.entity, endpoint.by_secure_discovery))
    return true;
  if (known->second.data == endpoint) return false;
  read_again_later(remote);
  return true;
}

void ClearAnnouncements::note_ended(RemoteParticipant& remote, const EntityId& endpoint,
                                    bool secure) {
  if (remote.endpoints.contains(endpoint) && is_doubtful(remote, endpoint, secure))
    read_again_later(remote);
}

bool ClearAnnouncements::is_doubtful(const RemoteParticipant& remote, const EntityId& endpoint,
                                     bool secure) const {
  return core_.is_authenticated(remote.prefix()) &&
         core_.origin_of_announcement({remote.prefix(), endpoint}, secure) == Origin::anyone;
}

void ClearAnnouncements::read_again_later(RemoteParticipant& remote) {
  remote.second_reading.note_change(core_.now);
  call_at(remote.second_reading.due());
}

void ClearAnnouncements::on_time(MonotonicTime now) {
  auto next = kNever;
  for (const auto& [prefix, known] : remotes_.all()) {
    auto& remote = *remotes_.find(prefix);
    if (remote.second_reading.take_due(now)) builtin_.read_again(remote);
    next = std::min(next, remote.second_reading.due());
  }
  call_at(next);
}

}  // namespace ddssec::rtps
