#include "rtps/participant/match_places.hpp"

#include <fmt/format.h>

namespace ddssec::rtps {

bool MatchPlaces::has_macs(const EntityId& local) const {
  return core_.security && core_.security->keyring().levels(local).receiver_macs;
}

bool MatchPlaces::has_place(const Local& local, RemoteParticipant& remote,
                            const EndpointData& endpoint) {
  if (remote.prefix() == core_.config.prefix) return true;
  const auto identity = core_.identity_of(remote.prefix());
  const bool macs = has_macs(local.id);
  if (local.matched.has_room(identity, macs) || replaceable_match(local, endpoint)) return true;
  local.waiting.add(endpoint.guid, identity, core_.is_proven(endpoint));
  ++core_.counters.refused_discovery;
  if (std::exchange(remote.exceeds_matches, true)) return false;
  auto expected = fmt::format("at most {} endpoints of one identity that match one of ours",
                              MatchTable::kMaxOfOne);
  if (macs)
    expected += fmt::format(
        ", and with origin authentication at most {} of all, and of one identity no more than "
        "places are free",
        MatchTable::kMaxWithMacs);
  core_.raise_about(
      Error(Code::rtps_too_many_endpoints, {.expected = std::move(expected), .found = "more"}),
      endpoint);
  return false;
}

// Returns an unproven match of the identity that can be replaced. Any host can have announced many
// endpoints in the name of the identity before this one was announced.
std::optional<Guid> MatchPlaces::replaceable_match(const Local& local,
                                                   const EndpointData& endpoint) const {
  const auto identity = core_.identity_of(endpoint.guid.prefix);
  const bool macs = has_macs(local.id);
  if (!core_.is_proven(endpoint) || local.matched.has_room(identity, macs)) return std::nullopt;
  return local.matched.replaceable(identity, macs);
}

void MatchPlaces::note_displaced(const Local& local, const Guid& remote) {
  local.waiting.add(remote, core_.identity_of(remote.prefix), false);
}

void MatchPlaces::claim(const Local& local, const EndpointData& endpoint) {
  local.matched.add(endpoint.guid, core_.identity_of(endpoint.guid.prefix),
                    core_.is_proven(endpoint));
}

// Waiting endpoints are not matched while a match ends, because its participant may be about to
// leave with all its endpoints.
void MatchPlaces::note_room(const Local& local) {
  if (local.waiting.empty()) return;
  with_room_.insert(local.id);
  call_at(core_.now);
}

void MatchPlaces::on_time(MonotonicTime now) {
  for (const auto& id : std::exchange(with_room_, {})) {
    if (auto* writer = local_.find_writer(id)) fill(Local(*writer));
    if (auto* reader = local_.find_reader(id)) fill(Local(*reader));
  }
  if (!with_room_.empty()) call_at(now + kPause);
}

void MatchPlaces::fill(const Local& local) {
  const bool macs = has_macs(local.id);
  const auto has_room = [&](const GuidPrefix& identity) {
    return local.matched.has_room(identity, macs);
  };
  for (int i = 0; i < kMaxTries; ++i) {
    const auto next = local.waiting.take(has_room);
    if (!next) return;
    match_again_(local.id, *next);
  }
  if (!local.waiting.empty()) with_room_.insert(local.id);
}

}  // namespace ddssec::rtps
