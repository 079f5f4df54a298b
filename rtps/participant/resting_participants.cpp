#include "rtps/participant/resting_participants.hpp"

#include "rtps/participant/remote_addresses.hpp"

namespace ddssec::rtps {
namespace {

// Returns what is known of the participant itself.
RemoteParticipant without_session(const RemoteParticipant& remote) {
  auto out = remote;
  out.unproven.reset();
  out.accepted = false;
  out.account = out.prefix();
  out.signals = {};
  out.watches.clear();
  out.announcement_refresh = {};
  out.next_offer = kNever;
  out.unconfirmed.clear();
  return out;
}

}  // namespace

// A dormant peer is sent any amount, so it must have proved one of its addresses.
bool RestingParticipants::can_keep(const RemoteParticipant& remote) const {
  return core_.security && core_.security->dormant().can_keep(remote.prefix()) &&
         has_proven_address(core_, remote) && remote.announced[1].octets <= kMaxEndpointOctets;
}

// Endpoints that anyone can have announced are not kept: they are announced again when the
// participant is asked.
void RestingParticipants::rest(RemoteParticipant& remote) {
  const auto prefix = remote.prefix();
  std::vector<EndpointData> endpoints;
  for (const auto& [id, endpoint] : remote.endpoints)
    if (endpoint.is_proven) endpoints.push_back(endpoint.data);
  matcher_.remove_all(remote, true);
  builtin_.unmatch(remote, true);
  core_.sender.flush_now();
  core_.sender.amplification_limit().end(prefix);
  auto& dormant = core_.security->dormant();
  dormant.keep(prefix);
  resting_.insert_or_assign(prefix, RestingRemote{without_session(remote), std::move(endpoints)});
  remotes_.remove(prefix);
  std::erase_if(resting_, [&](const auto& one) { return !dormant.contains(one.first); });
}

RemoteParticipant* RestingParticipants::wake(const GuidPrefix& prefix) {
  const auto at = resting_.find(prefix);
  if (at == resting_.end() || !core_.security->wake(prefix)) return nullptr;
  core_.sender.amplification_limit().end(prefix);
  return &remotes_.restore(at->second.remote);
}

void RestingParticipants::match_again(RemoteParticipant& remote) {
  const auto kept = resting_.extract(remote.prefix());
  if (kept.empty()) return;
  for (auto& endpoint : kept.mapped().endpoints) matcher_.add(remote, std::move(endpoint));
}

}  // namespace ddssec::rtps
