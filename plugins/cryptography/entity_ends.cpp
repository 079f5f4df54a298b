// The end of participants, endpoints and matches.
#include "plugins/cryptography/key_factory.hpp"

namespace ddssec::cryptography {
namespace {

// Calls `drop` with each handle, and empties the set. `drop` may remove handles. The set is not
// copied: after many objects have ended, one large allocation takes glibc 28 ms.
template <class Drop>
void take_each(std::unordered_set<std::int64_t>& handles, const Drop& drop) {
  while (!handles.empty()) {
    const auto handle = *handles.begin();
    drop(handle);
    handles.erase(handle);
  }
}

}  // namespace

// An object that ends is first removed from the tables that lead to it, then from the registry,
// then retired. A route stays for a while and leads nowhere, because the registry no longer knows
// the handle (routes.hpp).

void KeyFactory::drop(const CryptoEntity& entity) {
  state_.retired_objects.retire(state_.registry.remove(entity));
}

void KeyFactory::drop_remote(RemoteEndpointCrypto& endpoint) {
  endpoint.local.matched.erase(endpoint.handle());
  endpoint.participant.endpoints.erase(endpoint.handle());
  state_.release_place(endpoint);
  endpoint.local.matches.release(endpoint.match_subject);
  if (endpoint.is_counted_by_discovery_work)
    endpoint.participant.discovery.work.note_end_of_match(endpoint.local.handle(),
                                                          endpoint.local.matched.size());
  release_peer_key(endpoint);
  if (endpoint.route != 0) endpoint.participant.routes.note_gone();
  drop(endpoint);
}

void KeyFactory::drop_local(LocalEndpointCrypto& endpoint) {
  const auto kind = endpoint.kind() == EntityKind::local_writer ? EntityKind::remote_reader
                                                                : EntityKind::remote_writer;
  take_each(endpoint.matched, [&](std::int64_t handle) {
    if (const auto remote = state_.registry.find<RemoteEndpointCrypto>(handle, kind))
      drop_remote(**remote);
  });
  endpoint.participant.endpoints.erase(endpoint.handle());
  drop(endpoint);
}

bool KeyFactory::poll_stranded_keys(spi::IdentityHandle remote) {
  const std::lock_guard lock(state_.mutex);
  const auto known = by_identity_.find(remote.value);
  if (state_.host_checks_sources || known == by_identity_.end()) return false;
  const auto now = state_.services.clock.monotonic();
  bool are_stranded = false;
  for (const auto& [local, pair] : known->second->pairs)
    are_stranded |= pair && state_.ledger.poll_stranded(pair->number, now);
  return are_stranded;
}

void KeyFactory::cut_off(spi::ParticipantCryptoHandle local) {
  const ReadGuard guard;
  if (const auto participant = state_.local_participant(local)) (*participant)->is_cut_off = true;
}

void KeyFactory::drop_remote(RemoteParticipantCrypto& participant) {
  take_each(participant.endpoints, [&](std::int64_t handle) {
    for (const auto kind : {EntityKind::remote_writer, EntityKind::remote_reader})
      if (const auto endpoint = state_.registry.find<RemoteEndpointCrypto>(handle, kind))
        drop_remote(**endpoint);
  });
  for (const auto& [local, pair] : participant.pairs) {
    if (!pair) continue;
    if (!state_.host_checks_sources)
      state_.ledger.end(pair->number, state_.services.clock.monotonic());
    const auto found = state_.local_participant(spi::ParticipantCryptoHandle{local});
    if (!found) continue;
    (*found)->matched.erase(participant.handle());
    (*found)->receivers.release(pair->place_subject);
  }
  by_identity_.erase(participant.identity);
  drop(participant);
}

void KeyFactory::drop_local(LocalParticipantCrypto& participant) {
  take_each(participant.endpoints, [&](std::int64_t handle) {
    for (const auto kind : {EntityKind::local_writer, EntityKind::local_reader})
      if (const auto endpoint = state_.registry.find<LocalEndpointCrypto>(handle, kind))
        drop_local(**endpoint);
  });
  for (const auto handle : participant.matched) {
    const auto remote = state_.remote_participant(spi::ParticipantCryptoHandle{handle});
    if (!remote) continue;
    publish_pairs(**remote, participant.handle());
    if (auto pair = (*remote)->pairs.extract(participant.handle()))
      state_.retired_objects.retire(std::move(pair.mapped()));
  }
  drop(participant);
}

Status KeyFactory::unregister_participant(spi::ParticipantCryptoHandle participant) {
  const std::lock_guard lock(state_.mutex);
  if (const auto local = state_.local_participant(participant)) {
    drop_local(**local);
    return {};
  }
  DDSSEC_ASSIGN_OR_RETURN(const auto remote_participant, state_.remote_participant(participant));
  drop_remote(*remote_participant);
  return {};
}

Status KeyFactory::unregister_endpoint(std::int64_t handle, EntityKind local, EntityKind remote) {
  const std::lock_guard lock(state_.mutex);
  if (const auto endpoint = state_.registry.find<LocalEndpointCrypto>(handle, local)) {
    drop_local(**endpoint);
    return {};
  }
  DDSSEC_ASSIGN_OR_RETURN(const auto remote_endpoint,
                          state_.registry.find<RemoteEndpointCrypto>(handle, remote));
  drop_remote(*remote_endpoint);
  return {};
}

Status KeyFactory::unregister_datawriter(spi::DatawriterCryptoHandle datawriter) {
  return unregister_endpoint(datawriter.value, EntityKind::local_writer, EntityKind::remote_writer);
}

Status KeyFactory::unregister_datareader(spi::DatareaderCryptoHandle datareader) {
  return unregister_endpoint(datareader.value, EntityKind::local_reader, EntityKind::remote_reader);
}

}  // namespace ddssec::cryptography
