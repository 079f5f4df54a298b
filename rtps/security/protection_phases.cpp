#include "rtps/security/protection_phases.hpp"

namespace ddssec::rtps {

void ProtectionPhases::swap() noexcept {
  endpoints_.swap();
  messages_.swap();
  has_swapped_ = true;
}

void ProtectionPhases::remove_second() {
  endpoints_.remove_all();
  messages_.remove_second();
  has_swapped_ = false;
}

void ProtectionPhases::note_sends_next(const GuidPrefix& peer, bool sends_next) {
  const auto at = remotes_.find(peer);
  if (at != remotes_.end())
    at->second.sends_next = sends_next || (has_swapped_ && at->second.sends_next);
}

bool ProtectionPhases::may_send_by_former(const GuidPrefix& peer) const {
  const auto at = remotes_.find(peer);
  return has_swapped_ && at != remotes_.end() && !at->second.sends_next;
}

bool ProtectionPhases::must_protect_messages(const GuidPrefix& peer) const {
  return is_protected(may_send_by_former(peer) ? messages_.second_kind() : messages_.kind());
}

const LocalKeys* ProtectionPhases::demanded(const EntityId& id, const Guid& remote) const {
  if (may_send_by_former(remote.prefix))
    if (const auto* former = endpoints_.second_keys_of(id, remote)) return former;
  return find(locals_, id);
}

}  // namespace ddssec::rtps
