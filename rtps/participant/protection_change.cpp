#include "rtps/participant/protection_change.hpp"

namespace ddssec::rtps {
namespace {

// From now on, a reader that took the key hash from beside the data computes it. Key hashes of
// existing endpoints keep their form, because instances are identified by them. The governance
// accepts such a change only if submessages or messages are encrypted.
template <class Local>
void announce(ParticipantCore& core, LocalEndpoints& locals, std::map<EntityId, Local>& endpoints) {
  for (auto& [id, local] : endpoints) {
    const auto announced = core.security->admission().announced(id);
    if (!announced) {
      core.raise_about(announced.error(), local.data);
      continue;
    }
    if (announced->info == local.data.security_info) continue;
    local.data.security_info = announced->info;
    local.data.required_ciphers = announced->required_ciphers;
    if (core.security->keyring().attributes(id)->is_payload_protected())
      local.listener->on_payload_protected();
    locals.publish(local.data);
  }
}

}  // namespace

void announce_protection(ParticipantCore& core, LocalEndpoints& locals, RemoteParticipants& remotes,
                         EndpointMatcher& matcher) {
  announce(core, locals, locals.writers());
  announce(core, locals, locals.readers());
  std::vector<GuidPrefix> open;
  for (const auto& [prefix, remote] : remotes.all())
    if (!core.security->is_authenticated(prefix)) open.push_back(prefix);
  for (const auto& prefix : open)
    if (auto* remote = remotes.find(prefix)) matcher.match_all(*remote);
}

}  // namespace ddssec::rtps
