#include "rtps/participant/protection_change.hpp"

#include <algorithm>

namespace ddssec::rtps {
namespace {

// True if the endpoint was announced without protection until now.
bool moves(const ParticipantCore& core, const EntityId& id) {
  const auto& keyring = core.security->keyring();
  const auto* former = keyring.phases().endpoints().attributes(id);
  return former != nullptr && !former->topic.is_discovery_protected &&
         keyring.attributes(id)->topic.is_discovery_protected;
}

// Peers without the document cannot read what is sent now, and acknowledge nothing.
bool is_received(const ParticipantCore& core, const StatefulWriter& writer) {
  return std::ranges::all_of(writer.readers().all(), [&](const auto& one) {
    const auto& [reader, proxy] = one;
    return !core.security->core().takes_part(reader.prefix) ||
           proxy.acknowledged() >= writer.history().last();
  });
}

// A filter would tell what an encrypted payload holds (EndpointMatcher).
void note_encryption(LocalWriter& writer) {
  std::vector<Guid> filtered;
  for (const auto& [guid, proxy] : writer.protocol->readers().all())
    if (proxy.reader().filter) filtered.push_back(guid);
  for (const auto& guid : filtered) writer.protocol->set_filter(guid, nullptr);
}
void note_encryption(LocalReader&) {}

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
    const auto& attributes = *core.security->keyring().attributes(id);
    if (attributes.is_payload_protected()) local.listener->on_payload_protected();
    if (is_encrypted(attributes.payload) || is_encrypted(attributes.submessage))
      note_encryption(local);
    if (moves(core, id))
      locals.publish_moved(local.data);
    else
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

bool are_moves_received(const ParticipantCore& core, LocalEndpoints& locals) {
  auto& builtin = locals.builtin();
  return !locals.any_moves() ||
         (is_received(core, builtin.writer(BuiltinTopic::publications_secure)) &&
          is_received(core, builtin.writer(BuiltinTopic::subscriptions_secure)));
}

void forget_refused(ParticipantCore& core, RemoteParticipants& remotes) {
  std::vector<GuidPrefix> refused;
  for (const auto& [prefix, remote] : remotes.all())
    if (!remote.accepted && !core.security->knows(prefix)) refused.push_back(prefix);
  core.sender.flush_now();  // waiting messages count for the limit
  for (const auto& prefix : refused) {
    core.sender.amplification_limit().end(prefix);
    remotes.remove(prefix);
  }
}

}  // namespace ddssec::rtps
