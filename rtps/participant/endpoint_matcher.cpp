#include "rtps/participant/endpoint_matcher.hpp"

#include <algorithm>

#include "base/rollback.hpp"
#include "rtps/participant/endpoint_compatibility.hpp"
#include "rtps/participant/remote_addresses.hpp"
#include "rtps/participant/shared_memory.hpp"
#include "wire/vendor_name.hpp"

namespace ddssec::rtps {
namespace {

KeyReading key_reading_of(const ParticipantData& data) {
  return {data.vendor == kVendorCyclone && is_up_to(data.vendor_version, 0, 10),
          data.vendor == kVendorFastDds};
}

bool contains(const auto& list, const auto& value) {
  return std::ranges::find(list, value) != list.end();
}

// Access control is checked first, so that a participant that may not use the topic cannot change a
// local status. Returns nothing if the two do not match.
std::optional<Admission::Permission> judge(ParticipantCore& core, const EndpointData& local,
                                           EndpointListener& listener, const EndpointData& remote) {
  const bool is_secured = core.security && remote.guid.prefix != core.config.prefix;
  std::optional permission = Admission::Permission();
  if (is_secured)
    permission = core.security->admit(local.guid.entity, Admission::Endpoint::of(remote));
  if (!permission || !is_compatible(local, remote, listener, core)) return std::nullopt;
  return permission;
}

// Returns false if the keys of the pair have not arrived yet.
bool register_pair(ParticipantCore& core, const EntityId& local, const Guid& remote,
                   const Admission::Permission& permission) {
  if (!core.security || remote.prefix == core.config.prefix) return true;
  return core.security->register_pair(local, remote, permission.is_relay_only);
}

AfterMatch after_match(bool may_return) {
  return may_return ? AfterMatch::may_return : AfterMatch::gone;
}

// Suspends the pair if it is registered, because there was a place for it once.
void suspend_pair(ParticipantCore& core, const EntityId& local, const Guid& remote) {
  if (core.security)
    core.security->keyring().unregister_pair(local, remote, AfterMatch::may_return);
}

// Whether a sample passes a filter shows in its inline QoS, or in a GAP in its place. So filters
// would tell others what an encrypted payload holds, and a forged announcement could choose them.
// The reader applies its filter in any case (RTPS 2.5, 8.7.3).
bool may_filter(const ParticipantCore& core, const LocalWriter& writer) {
  if (!core.security) return true;
  const auto* attributes = core.security->keyring().attributes(writer.data.guid.entity);
  return attributes == nullptr ||
         !(is_encrypted(attributes->payload) || is_encrypted(attributes->submessage));
}

}  // namespace

EndpointMatcher::EndpointMatcher(ParticipantCore& core, LocalEndpoints& local,
                                 RemoteParticipants& remotes)
    : core_(core),
      local_(local),
      remotes_(remotes),
      places_(core, local, [this](const EntityId& own, const Guid& remote) { match(own, remote); }),
      presence_(core, local, remotes, places_,
                [this](const EntityId& writer, const Guid& reader) { match(writer, reader); }) {}

// ---- local endpoints

void EndpointMatcher::add(LocalWriter& writer) {
  topics_[writer.data.topic_name].writers.push_back(&writer);
  match_all(writer);
}

void EndpointMatcher::add(LocalReader& reader) {
  topics_[reader.data.topic_name].readers.push_back(&reader);
  match_all(reader);
}

template <class Local>
void EndpointMatcher::match_remotes(Local& local) {
  for (const auto& guid : topics_[local.data.topic_name].remotes) {
    auto& remote = *remotes_.find(guid.prefix);
    match(local, remote, remote.endpoints.find(guid.entity)->second.data);
  }
}

void EndpointMatcher::match_all(LocalWriter& writer) {
  match_remotes(writer);
  for (auto* reader : topics_[writer.data.topic_name].readers) match_own(writer, *reader);
}

void EndpointMatcher::match_all(LocalReader& reader) {
  match_remotes(reader);
  for (auto* writer : topics_[reader.data.topic_name].writers) match_own(*writer, reader);
}

void EndpointMatcher::match_own() {
  for (auto& [id, writer] : local_.writers())
    for (auto& [other, reader] : local_.readers()) match_own(writer, reader);
}

void EndpointMatcher::match_own(LocalWriter& writer, LocalReader& reader) {
  if (core_.ignored.contains(writer.data) || core_.ignored.contains(reader.data)) {
    forget(writer, reader.data.guid);
    forget(reader, writer.data.guid);
    return;
  }
  auto& self = remotes_.self();
  self.endpoints[writer.data.guid.entity].data = writer.data;
  self.endpoints[reader.data.guid.entity].data = reader.data;
  match(writer, self, reader.data);
  match(reader, self, writer.data);
}

void EndpointMatcher::remove(LocalWriter& writer) {
  note_own_writer_gone(core_, writer.data.guid.entity);
  auto& ends = topics_[writer.data.topic_name];
  part_from(ends.readers, writer.data.guid);
  std::erase(ends.writers, &writer);
  forget_if_empty(writer.data.topic_name);
}

void EndpointMatcher::remove(LocalReader& reader) {
  for (const auto& guid : reader.matched.guids()) {
    note_writer_gone(core_, reader.data.guid.entity, guid);
    if (auto* remote = remotes_.find_or_self(guid.prefix))
      remote->stop_watching(*reader.listener, guid);
    if (auto* remote = remotes_.find_endpoint(guid))
      std::erase(remote->readers, reader.protocol.get());
  }
  auto& ends = topics_[reader.data.topic_name];
  part_from(ends.writers, reader.data.guid);
  std::erase(ends.readers, &reader);
  forget_if_empty(reader.data.topic_name);
}

template <class Local>
void EndpointMatcher::part_from(const std::vector<Local*>& others, const Guid& endpoint) {
  for (auto* other : others) forget(*other, endpoint);
  remotes_.self().endpoints.erase(endpoint.entity);
}

void EndpointMatcher::forget_if_empty(const std::string& topic_name) {
  if (const auto at = topics_.find(topic_name); at != topics_.end() && at->second.empty())
    topics_.erase(at);
}

// ---- remote endpoints

void EndpointMatcher::add(RemoteParticipant& remote, EndpointData data) {
  if (core_.ignored.contains(data)) return;
  const auto id = data.guid.entity;
  if (!remotes_.has_room(remote, data)) return;
  auto known = remote.endpoints.find(id);
  if (known != remote.endpoints.end() && known->second.data.topic_name != data.topic_name) {
    remove(remote, id);
    known = remote.endpoints.end();
  }
  const bool moves = known != remote.endpoints.end() && known->second.data.unicast != data.unicast;
  auto& ends = topics_[data.topic_name];
  const auto [listed, is_new] = ends.remotes.insert(data.guid);
  Rollback unlisted([&] {
    if (is_new) ends.remotes.erase(listed);
  });
  const auto& stored = remotes_.store(remote, std::move(data)).data;
  unlisted.release();
  for (auto* writer : ends.writers) {
    writer->silent.erase(stored.guid);
    match(*writer, remote, stored);
  }
  for (auto* reader : ends.readers) match(*reader, remote, stored);
  // The former address stays counted (ClearAddresses) until the endpoint ends.
  if (moves) readdress(remote, remote.endpoints.at(id));
}

void EndpointMatcher::remove(RemoteParticipant& remote, const EntityId& id, bool may_return) {
  const auto known = remote.endpoints.find(id);
  if (known == remote.endpoints.end()) return;
  const auto& data = known->second.data;
  const auto topic_name = data.topic_name;
  auto& ends = topics_[topic_name];
  for (auto* writer : ends.writers) forget(*writer, data.guid, may_return);
  for (auto* reader : ends.readers) forget(*reader, data.guid, may_return);
  ends.remotes.erase(data.guid);
  remotes_.remove(remote, id);
  forget_if_empty(topic_name);
}

void EndpointMatcher::note_unproven_end(RemoteParticipant& remote, const EntityId& id) {
  const auto known = remote.endpoints.find(id);
  if (known == remote.endpoints.end() || !is_reader(id)) return;
  const auto& data = known->second.data;
  for (auto* writer : topics_[data.topic_name].writers)
    presence_.note_unproven_end(*writer, data.guid);
}

bool EndpointMatcher::match_all(RemoteParticipant& remote) {
  bool any_lost = false;
  const auto match_again = [&](auto& local, const EndpointData& data) {
    const auto& own = local.data.guid.entity;
    if (is_writer(own) == is_writer(data.guid.entity)) return;
    // An endpoint that withholds its own keys has ours, although it is not matched.
    auto& keyring = core_.security->keyring();
    const bool is_matched = local.matched.contains(data.guid);
    if (is_matched || keyring.is_pair_registered(own, data.guid)) {
      const auto permission = core_.security->admit(own, Admission::Endpoint::of(data));
      const bool is_relay = keyring.kind_of(own, data.guid) == Keyring::PairKind::relay_only;
      const bool stays = permission && permission->is_relay_only == is_relay;
      if (stays && is_matched) return;
      if (!stays) forget(local, data.guid, true);
      any_lost = any_lost || !stays;
      if (!permission) return;
    }
    match(local, remote, data);
  };
  for (const auto& [id, endpoint] : remote.endpoints) {
    const auto& ends = topics_[endpoint.data.topic_name];
    for (auto* writer : ends.writers) match_again(*writer, endpoint.data);
    for (auto* reader : ends.readers) match_again(*reader, endpoint.data);
  }
  return any_lost;
}

void EndpointMatcher::remove_all(RemoteParticipant& remote, bool may_return) {
  while (!remote.endpoints.empty())
    remove(remote, EntityId(remote.endpoints.begin()->first), may_return);
}

void EndpointMatcher::readdress(RemoteParticipant& remote) {
  remote.clear_addresses.clear();
  for (const auto& [id, endpoint] : remote.endpoints) readdress(remote, endpoint);
}

void EndpointMatcher::readdress(RemoteParticipant& remote, const RemoteEndpoint& endpoint) {
  const auto& data = endpoint.data;
  const auto& writers = topics_[data.topic_name].writers;
  const auto is_used = [&](const auto* writer) { return writer->matched.contains(data.guid); };
  if (endpoint.readers.empty() && std::ranges::none_of(writers, is_used)) return;
  const auto addresses = addresses_of(core_, remote, data);
  for (auto* writer : writers) writer->protocol->readdress(data.guid, addresses, core_.now);
  for (auto* reader : endpoint.readers) reader->readdress(data.guid, addresses);
}

void EndpointMatcher::remove_topic(const std::string& name) {
  const auto at = topics_.find(name);
  if (at == topics_.end()) return;
  for (const auto& guid : std::set(at->second.remotes))
    remove(*remotes_.find(guid.prefix), guid.entity);
  for (auto& [id, writer] : local_.writers())
    if (writer.data.topic_name == name) match_all(writer);
}

std::optional<EndpointData> EndpointMatcher::endpoint_on(const std::string& topic_name) const {
  const auto at = topics_.find(topic_name);
  if (at == topics_.end() || at->second.remotes.empty()) return std::nullopt;
  return *remotes_.endpoint(*at->second.remotes.begin());
}

// ---- both

template <class Local>
void EndpointMatcher::claim_place(Local& local, const EndpointData& endpoint) {
  const MatchPlaces::Local of(local);
  if (const auto other = places_.replaceable_match(of, endpoint)) {
    forget(local, *other, true);
    places_.note_displaced(of, *other);
  }
  places_.claim(of, endpoint);
}

void EndpointMatcher::match(const EntityId& local, const Guid& remote) {
  auto* participant = remotes_.find(remote.prefix);
  const auto* data = remotes_.endpoint(remote);
  if (participant == nullptr || data == nullptr) return;
  if (auto* writer = local_.find_writer(local)) match(*writer, *participant, *data);
  if (auto* reader = local_.find_reader(local)) match(*reader, *participant, *data);
}

void EndpointMatcher::match(LocalWriter& writer, RemoteParticipant& remote,
                            const EndpointData& data) {
  if (!is_reader(data.guid.entity)) return;
  const bool known = writer.matched.contains(data.guid);
  const auto permission = judge(core_, writer.data, *writer.listener, data);
  if (!permission) return forget(writer, data.guid, true);
  const bool is_silent = writer.silent.contains(data.guid);
  if (is_silent) return;
  if (!known && !places_.has_place(MatchPlaces::Local(writer), remote, data))
    return suspend_pair(core_, writer.data.guid.entity, data.guid);
  if (!register_pair(core_, writer.data.guid.entity, data.guid, *permission)) return;
  // A reader in this process gets each sample directly and filters by itself.
  const auto* near =
      process_peer_of(local_, core_.config.process_peers.get(), writer.data.guid.entity, data.guid);
  const bool is_in_process = near != nullptr;
  auto filter = data.content_filter && !is_in_process && may_filter(core_, writer)
                    ? writer.listener->filter_for(data)
                    : nullptr;
  if (known) {
    writer.protocol->set_filter(data.guid, std::move(filter));
    if (!writer.unready.contains(data.guid)) writer.listener->on_matched(data);
    return;
  }
  claim_place(writer, data);
  const bool waits = presence_.awaits(writer, data);
  const bool history = data.qos.durability >= DurabilityKind::transient_local;
  const auto locators = is_in_process ? LocatorList{} : addresses_of(core_, remote, data);
  writer.protocol->match({data.guid, data.qos.is_reliable(), history, locators, is_in_process,
                          std::move(filter), key_reading_of(remote.data)},
                         core_.now);
  if (!waits) writer.listener->on_matched(data);
  if (is_in_process) return join_in_process(local_, *near, writer.data.guid, data.guid);
  note_reader(core_, writer, remote, data.guid, locators);
}

void EndpointMatcher::match(LocalReader& reader, RemoteParticipant& remote,
                            const EndpointData& data) {
  if (!is_writer(data.guid.entity)) return;
  const auto own = reader.data.guid;
  auto& matched = remote.endpoints.find(data.guid.entity)->second.readers;
  const bool known = contains(matched, reader.protocol.get());
  if (known) remote.stop_watching(*reader.listener, data.guid);
  const auto permission = judge(core_, reader.data, *reader.listener, data);
  if (!permission) return forget(reader, data.guid, true);
  if (!known && !places_.has_place(MatchPlaces::Local(reader), remote, data))
    return suspend_pair(core_, own.entity, data.guid);
  if (!register_pair(core_, own.entity, data.guid, *permission)) return;
  if (known) {
    reader.listener->on_matched(data);
    return remote.watch(*reader.listener, data, core_.now);
  }
  claim_place(reader, data);
  matched.push_back(reader.protocol.get());
  const auto identity = core_.identity_of(data.guid.prefix);
  const auto* near =
      process_peer_of(local_, core_.config.process_peers.get(), own.entity, data.guid);
  const bool is_in_process = near != nullptr;
  const bool history =
      std::min(data.qos.durability, reader.data.qos.durability) >= DurabilityKind::transient_local;
  const auto locators = is_in_process ? LocatorList{} : addresses_of(core_, remote, data);
  reader.protocol->match({data.guid, data.qos.is_reliable(), locators, is_in_process,
                          core_.keys_of(own.entity, data.guid), identity},
                         core_.now, history);
  reader.listener->on_matched(data);
  remote.watch(*reader.listener, data, core_.now);
  if (is_in_process) return join_in_process(local_, *near, own, data.guid);
  note_writer(core_, own.entity, remote, data.guid, locators);
}

void EndpointMatcher::forget(LocalWriter& writer, const Guid& remote, bool stays) {
  if (core_.security)
    core_.security->keyring().unregister_pair(writer.data.guid.entity, remote, after_match(stays));
  presence_.forget(writer, remote);
  writer.waiting.remove(remote);
  if (!writer.matched.remove(remote)) return;
  writer.protocol->unmatch(remote);
  note_reader_gone(core_, writer.data.guid.entity, remote);
  writer.listener->on_unmatched(remote);
  places_.note_room(MatchPlaces::Local(writer));
}

void EndpointMatcher::forget(LocalReader& reader, const Guid& remote, bool stays) {
  const auto keys = core_.keys_of(reader.data.guid.entity, remote);
  if (core_.security)
    core_.security->keyring().unregister_pair(reader.data.guid.entity, remote, after_match(stays));
  reader.waiting.remove(remote);
  if (!reader.matched.remove(remote)) return;
  if (auto* participant = remotes_.find_or_self(remote.prefix))
    participant->stop_watching(*reader.listener, remote);
  if (auto* endpoint = remotes_.find_endpoint(remote))
    std::erase(endpoint->readers, reader.protocol.get());
  reader.protocol->unmatch(remote, keys);
  note_writer_gone(core_, reader.data.guid.entity, remote);
  reader.listener->on_unmatched(remote);
  places_.note_room(MatchPlaces::Local(reader));
}

}  // namespace ddssec::rtps
