#include "rtps/participant/proven_refreshes.hpp"

#include <utility>

namespace ddssec::rtps {
namespace {

constexpr MonotonicTime kPeriod = std::chrono::seconds(1);

bool are_proven(const spi::ParticipantSecurityAttributes& attributes, bool secure) {
  return attributes.is_rtps_protected() || (secure && attributes.is_discovery_protected());
}

}  // namespace

void ProvenRefreshes::begin(const spi::ParticipantSecurityAttributes& former) {
  for (const bool secure : {false, true}) {
    if (are_proven(former, secure) || !are_proven(core_.attributes(), secure)) continue;
    for (const auto& [prefix, known] : remotes_.all())
      if (core_.is_authenticated(prefix)) begin(*remotes_.find(prefix), secure);
    next_ = core_.now + kPeriod;
  }
}

void ProvenRefreshes::read_again(const GuidPrefix& participant) {
  auto* remote = remotes_.find(participant);
  if (remote == nullptr || !core_.is_authenticated(participant)) return;
  for (const bool secure : {false, true}) {
    if (!are_proven(core_.attributes(), secure)) continue;
    begin(*remote, secure, true);
    next_ = core_.now + kPeriod;
  }
}

void ProvenRefreshes::begin(RemoteParticipant& remote, bool secure, bool drops_recorded) {
  for (const auto& [id, endpoint] : remote.endpoints)
    if (endpoint.data.by_secure_discovery == secure) remote.unconfirmed.insert(id);
  builtin_.refresh_announcements(remote, secure, drops_recorded);
  if (secure) builtin_.refresh_participant(remote, drops_recorded);
}

void ProvenRefreshes::note_announced(RemoteParticipant& remote, const EndpointData& endpoint) {
  const auto id = endpoint.guid.entity;
  if (remote.unconfirmed.erase(id) == 0) return;
  const auto known = remote.endpoints.find(id);
  if (known == remote.endpoints.end()) return;
  const auto &before = known->second.data.qos, &after = endpoint.qos;
  if (before.reliability.kind != after.reliability.kind || before.durability != after.durability)
    matcher_.remove(remote, id);
}

bool ProvenRefreshes::has_read(const RemoteParticipant& remote) const {
  return builtin_.has_read(remote, false) && builtin_.has_read(remote, true);
}

// A participant that does not answer is not matched for longer than its lease.
void ProvenRefreshes::tick() {
  if (!core_.security) return;
  if (const auto former = core_.security->take_former_domain()) begin(*former);
  if (core_.now < next_) return;
  next_ = kNever;
  for (const auto& [prefix, known] : remotes_.all()) {
    if (known.unconfirmed.empty()) continue;
    auto& remote = *remotes_.find(prefix);
    if (has_read(remote))
      for (const auto& id : std::exchange(remote.unconfirmed, {})) matcher_.remove(remote, id);
    if (!remote.unconfirmed.empty()) next_ = core_.now + kPeriod;
  }
}

}  // namespace ddssec::rtps
