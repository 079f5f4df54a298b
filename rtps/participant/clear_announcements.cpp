#include "rtps/participant/clear_announcements.hpp"

#include <algorithm>

namespace ddssec::rtps {
namespace {

// The policies of a remote endpoint that stay the same as long as it is matched.
bool differ_in_what_a_match_keeps(const Qos& before, const Qos& after) {
  return before.reliability.kind != after.reliability.kind || before.durability != after.durability;
}

// True if an ACKNACK that the participant's reader of announcements sent to another participant
// may count here as well (shows_receiver).
bool may_be_redirected(const ParticipantCore& core, const RemoteParticipant& remote) {
  if (!core.is_authenticated(remote.prefix())) return false;
  const auto* attributes = core.security->keyring().attributes(kPublicationsSecureWriter);
  return attributes != nullptr && attributes->is_submessage_protected() &&
         !spi::is_origin_authenticated(attributes->submessage) &&
         !core.attributes().is_rtps_protected();
}

// True if the peer announces the endpoint by secure discovery because the governance changes.
bool confirms(const ParticipantCore& core, const EndpointData& clear, const EndpointData& secure) {
  const auto& security = core.security->core();
  return security.governance_change.is_under_way() && security.takes_part(secure.guid.prefix) &&
         clear.topic_name == secure.topic_name && clear.type_name == secure.type_name &&
         !differ_in_what_a_match_keeps(clear.qos, secure.qos);
}

}  // namespace

ClearAnnouncements::ClearAnnouncements(ParticipantCore& core, LocalEndpoints& local,
                                       RemoteParticipants& remotes, EndpointMatcher& matcher,
                                       BuiltinMatcher& builtin)
    : TimedObject(core.timers),
      core_(core),
      local_(local),
      remotes_(remotes),
      matcher_(matcher),
      builtin_(builtin) {
  builtin_.on_contradiction([this](const Guid& writer) { note_contradiction(writer.prefix); });
}

// Participants that were found at the same time are not all read at the same time.
void ClearAnnouncements::begin(RemoteParticipant& remote) {
  const bool is_clear = is_doubtful(remote, kPublicationsWriter, false);
  if (!is_clear && !may_be_redirected(core_, remote)) return;
  const auto digest = sha256({core_.config.prefix.octets, remote.prefix().octets});
  const auto share = AnnouncementRefresh::kMaxPause / 256 * (1 + digest[0]);
  if (is_clear) remote.announcement_refresh.begin(core_.now, share);
  remote.next_offer = core_.now + kOfferPeriod;
  call_at(std::min(remote.announcement_refresh.next(), remote.next_offer));
}

void ClearAnnouncements::note_contradiction(const GuidPrefix& participant) {
  auto* remote = remotes_.find(participant);
  if (remote != nullptr && is_doubtful(*remote, kPublicationsWriter, false))
    note_change(remote->announcement_refresh);
}

void ClearAnnouncements::give_way_to(RemoteParticipant& remote, const EndpointData& secure) {
  const auto id = secure.guid.entity;
  const auto known = remote.endpoints.find(id);
  if (known != remote.endpoints.end() && !known->second.data.by_secure_discovery &&
      !confirms(core_, known->second.data, secure))
    matcher_.remove(remote, id);
}

bool ClearAnnouncements::note_announced(RemoteParticipant& remote, const EndpointData& endpoint) {
  const auto id = endpoint.guid.entity;
  auto& refresh = remote.announcement_refresh;
  if (!is_doubtful(remote, id, endpoint.by_secure_discovery)) {
    refresh.note_alive(id);
    return true;
  }
  const auto known = remote.endpoints.find(id);
  if (known == remote.endpoints.end()) {
    if (refresh.without_keys().contains(id)) note_change(refresh);
    return true;
  }
  if (known->second.data.topic_name != endpoint.topic_name) {
    note_change(refresh);
    return remove(remote, id, endpoint.by_secure_discovery);
  }
  refresh.note_alive(id);
  if (known->second.data == endpoint) return false;
  note_change(refresh);
  if (!differ_in_what_a_match_keeps(known->second.data.qos, endpoint.qos)) return true;
  // These policies are immutable, so one of the two announcements is forged.
  if (!refresh.is_under_way()) return false;
  matcher_.remove(remote, id, true);
  return true;
}

void ClearAnnouncements::note_change(AnnouncementRefresh& refresh) {
  refresh.note_change(core_.now);
  call_at(refresh.due());
}

// The keys are kept, because the participant sends those of an endpoint only once, as long as
// nothing ends for it.
bool ClearAnnouncements::remove(RemoteParticipant& remote, const EntityId& endpoint, bool secure) {
  bool may_return = false;
  if (remote.endpoints.contains(endpoint) && is_doubtful(remote, endpoint, secure)) {
    note_change(remote.announcement_refresh);
    may_return = has_keys({remote.prefix(), endpoint});
    if (may_return && !remote.announcement_refresh.note_end(endpoint, core_.now)) {
      matcher_.note_unproven_end(remote, endpoint);
      return false;
    }
  }
  matcher_.remove(remote, endpoint, may_return);
  return true;
}

bool ClearAnnouncements::is_doubtful(const RemoteParticipant& remote, const EntityId& endpoint,
                                     bool secure) const {
  return core_.is_authenticated(remote.prefix()) &&
         core_.origin_of_announcement({remote.prefix(), endpoint}, secure) == EventOrigin::anyone;
}

// While the governance changes, an endpoint may move to protected discovery. The end of its
// unprotected announcement does not count for it then.
bool ClearAnnouncements::is_proven(const RemoteParticipant& remote,
                                   const EntityId& endpoint) const {
  const auto known = remote.endpoints.find(endpoint);
  return known != remote.endpoints.end() && core_.is_proven(known->second.data);
}

// ---- keys

std::vector<EntityId> ClearAnnouncements::counterparts(const EntityId& endpoint) const {
  std::vector<EntityId> out;
  const auto add = [&](const auto& locals) {
    for (const auto& [id, local] : locals) out.push_back(id);
  };
  if (is_reader(endpoint))
    add(local_.writers());
  else
    add(local_.readers());
  return out;
}

bool ClearAnnouncements::has_keys(const Guid& endpoint) const {
  return core_.security &&
         std::ranges::any_of(counterparts(endpoint.entity), [&](const EntityId& local) {
           const auto keys = core_.security->keyring().keys_for(local, endpoint);
           return keys.have_come || keys.have_second_come;
         });
}

// A participant that has the keys of one of our endpoints does not send its own ones again by
// itself, so they are requested.
void ClearAnnouncements::request_missing_keys(RemoteParticipant& remote) {
  auto& refresh = remote.announcement_refresh;
  auto& without = refresh.without_keys();
  for (auto at = without.begin(); at != without.end();) {
    const auto endpoint = at->first;
    if (!remote.endpoints.contains(endpoint)) {
      ++at;
    } else if (request_keys({remote.prefix(), endpoint}, std::exchange(at->second, true))) {
      note_change(refresh);
      ++at;
    } else {
      at = without.erase(at);
    }
  }
}

bool ClearAnnouncements::request_keys(const Guid& endpoint, bool again) {
  bool any = false;
  for (const auto& local : counterparts(endpoint.entity)) {
    const auto keys = core_.security->keyring().keys_for(local, endpoint);
    if (!keys.are_awaited && !keys.are_second_awaited) continue;
    if (again) {
      core_.raise_about(Error(Code::rtps_keys_given_up), local, endpoint);
      return false;
    }
    core_.security->exchange().request_tokens(local, endpoint);
    any = true;
  }
  return any;
}

// ---- second refreshes

void ClearAnnouncements::on_refreshed(RemoteParticipant& remote) {
  auto& refresh = remote.announcement_refresh;
  if (!builtin_.has_read(remote)) return note_change(refresh);
  for (const auto& [endpoint, counts] : refresh.take_confirmed_ends()) {
    const bool is_known = remote.endpoints.contains(endpoint);
    if (is_known && (counts || is_proven(remote, endpoint))) continue;
    if (is_known) matcher_.remove(remote, endpoint, true);
    const auto dropped = refresh.note_gone(endpoint);
    if (!dropped || remote.endpoints.contains(*dropped)) continue;
    for (const auto& local : counterparts(*dropped))
      core_.security->keyring().unregister_pair(local, {remote.prefix(), *dropped});
  }
  request_missing_keys(remote);
}

void ClearAnnouncements::on_time(MonotonicTime now) {
  auto next = kNever;
  for (const auto& [prefix, known] : remotes_.all()) {
    auto& remote = *remotes_.find(prefix);
    auto& refresh = remote.announcement_refresh;
    if (refresh.end_refresh_if_over(now)) on_refreshed(remote);
    if (refresh.begin_refresh_if_due(now)) builtin_.refresh_announcements(remote);
    if (now >= remote.next_offer) {
      builtin_.offer_again(remote);
      remote.next_offer = now + kOfferPeriod;
    }
    next = std::min({next, refresh.next(), remote.next_offer});
  }
  call_at(next);
}

}  // namespace ddssec::rtps
