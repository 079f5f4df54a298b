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
  if (known->second.data.topic_name != endpoint.topic_name)
    remove(remote, endpoint.guid.entity, endpoint.by_secure_discovery);
  remote.second_reading.note_change(core_.now);
  call_at(remote.second_reading.due());
  return true;
}

// The participant sends the keys of an endpoint only once, as long as nothing ends for it.
void ClearAnnouncements::remove(RemoteParticipant& remote, const EntityId& endpoint, bool secure) {
  bool may_return = false;
  if (remote.endpoints.contains(endpoint) && is_doubtful(remote, endpoint, secure)) {
    may_return = remote.second_reading.note_end(endpoint, core_.now);
    call_at(remote.second_reading.due());
  }
  matcher_.remove(remote, endpoint, may_return);
}

bool ClearAnnouncements::is_doubtful(const RemoteParticipant& remote, const EntityId& endpoint,
                                     bool secure) const {
  return core_.is_authenticated(remote.prefix()) &&
         core_.origin_of_announcement({remote.prefix(), endpoint}, secure) == Origin::anyone;
}

void ClearAnnouncements::give_up(const RemoteParticipant& remote, std::span<const EntityId> ended) {
  if (!core_.security) return;
  auto& keyring = core_.security->keyring();
  for (const auto& endpoint : ended) {
    if (remote.endpoints.contains(endpoint)) continue;
    const Guid guid{remote.prefix(), endpoint};
    if (is_reader(endpoint))
      for (const auto& [id, writer] : local_.writers()) keyring.separate(id, guid);
    else
      for (const auto& [id, reader] : local_.readers()) keyring.separate(id, guid);
  }
}

void ClearAnnouncements::on_time(MonotonicTime now) {
  auto next = kNever;
  for (const auto& [prefix, known] : remotes_.all()) {
    auto& remote = *remotes_.find(prefix);
    auto& reading = remote.second_reading;
    give_up(remote, reading.take_read(now));
    if (reading.take_due(now)) builtin_.read_again(remote);
    next = std::min(next, reading.next());
  }
  call_at(next);
}

}  // namespace ddssec::rtps
