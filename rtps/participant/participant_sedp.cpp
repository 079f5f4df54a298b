// Participant, the half that finds endpoints and matches them (RTPS 8.5.4).
#include <algorithm>

#include <fmt/format.h>

#include "rtps/participant/participant.hpp"
#include "wire/vendor_name.hpp"

namespace ddssec::rtps {
namespace {

// Above whatever the bounds of its parameters allow.
constexpr std::size_t kLargestAnnouncement = 128 << 10;

// XTypes calls the topic inconsistent then; as the reader's policy is the reason, it is named.
std::optional<QosMismatch> refusal(const TypeJudgement& types, const EndpointData& writer,
                                   const EndpointData& reader) {
  return QosMismatch{
      QosPolicyId::type_consistency_enforcement, "TYPE_CONSISTENCY_ENFORCEMENT",
      describe_type(writer.type_name, writer.type),
      fmt::format("{} for {}", types.refused_by, describe_type(reader.type_name, reader.type))};
}

KeyReading key_reading_of(const ParticipantData& data) {
  return {data.vendor == kVendorCyclone && is_up_to(data.vendor_version, 0, 10),
          data.vendor == kVendorFastDds};
}

}  // namespace

void Participant::publish(const EndpointData& data, MonotonicTime now) {
  // Of so many octets few are written, and only those are to cost anything.
  const auto buffer = std::make_unique_for_overwrite<std::uint8_t[]>(kLargestAnnouncement);
  SpanWriter payload({buffer.get(), kLargestAnnouncement});
  if (data.qos.data_tags.empty() || is_announced_securely(data.guid.entity)) {
    write_payload(payload, data);
  } else {
    auto untagged = data;
    untagged.qos.data_tags.clear();
    write_payload(payload, untagged);
  }
  Change change;
  change.key_hash = data.guid.octets();
  change.payload = Payload::copy_of(payload.view());
  sedp_writer(data.guid.entity).write(std::move(change), now);
}

// DDS-Security 7.4.1.8: the governance says which topics are announced where only authenticated
// participants can read it.
bool Participant::is_announced_securely(const EntityId& endpoint) const {
  const auto* attributes = security_ ? security_->keyring().attributes(endpoint) : nullptr;
  return attributes != nullptr && attributes->topic.is_discovery_protected;
}

StatefulWriter& Participant::sedp_writer(const EntityId& endpoint) {
  const bool secure = is_announced_securely(endpoint);
  if (is_writer(endpoint))
    return builtin_.writer(secure ? BuiltinTopic::publications_secure : BuiltinTopic::publications);
  return builtin_.writer(secure ? BuiltinTopic::subscriptions_secure : BuiltinTopic::subscriptions);
}

void Participant::unpublish(const Guid& endpoint, MonotonicTime now) {
  std::array<std::uint8_t, 64> buffer;
  SpanWriter payload(buffer);
  write_endpoint_key(payload, endpoint);
  Change change;
  change.key_hash = endpoint.octets();
  change.status = {true, true};
  change.key_only = true;
  change.payload = Payload::copy_of(payload.view());
  sedp_writer(endpoint.entity).write(std::move(change), now);
}

// Nothing here is ever refused for now.
bool Participant::on_builtin(BuiltinTopic topic, const Change& change) {
  switch (topic) {
    case BuiltinTopic::publications:
    case BuiltinTopic::publications_secure:
      on_sedp(change, true, topic == BuiltinTopic::publications_secure);
      break;
    case BuiltinTopic::subscriptions:
    case BuiltinTopic::subscriptions_secure:
      on_sedp(change, false, topic == BuiltinTopic::subscriptions_secure);
      break;
    case BuiltinTopic::participant_message:
    case BuiltinTopic::participant_message_secure:
      on_participant_message(change, topic == BuiltinTopic::participant_message_secure);
      break;
    case BuiltinTopic::participants_secure:
      on_secure_participant(change);
      break;
  }
  return true;
}

// A participant speaks for its own endpoints only, and nothing that was said securely is unsaid
// otherwise.
void Participant::on_sedp(const Change& change, bool publications, bool secure) {
  const auto remote = remotes_.find(change.writer.prefix);
  if (remote == remotes_.end()) return;
  const auto may_change = [&](const EntityId& id) {
    const auto known = remote->second.endpoints.find(id);
    const bool good =
        known == remote->second.endpoints.end() || known->second.data.by_secure_discovery == secure;
    counters_.refused_discovery += good ? 0 : 1;
    return good;
  };
  if (!change.is_alive()) {
    const auto key = change.key_hash ? Guid{GuidPrefix::from(BytesView(*change.key_hash).first(12)),
                                            EntityId::from(BytesView(*change.key_hash).subspan(12))}
                                     : read_endpoint_key(change.payload.view()).value_or(Guid{});
    if (key.prefix == remote->first && may_change(key.entity))
      remove_endpoint(remote->second, key.entity);
    return;
  }
  auto data = publications ? read_publication_data(change.payload.view())
                           : read_subscription_data(change.payload.view());
  if (!data || data->guid.prefix != remote->first) {
    ++counters_.refused_discovery;
    if (!data) events_.raise(Event(data.error().in("SEDP"), {}, remote->first.to_string()));
    return;
  }
  data->by_secure_discovery = secure;
  if (may_change(data->guid.entity)) add_endpoint(remote->second, std::move(*data));
}

Participant::RemoteEndpoint* Participant::find_remote(const Guid& guid) {
  const auto known = remotes_.find(guid.prefix);
  auto* remote = guid.prefix == config_.prefix ? &self_
                 : known == remotes_.end()     ? nullptr
                                               : &known->second;
  if (remote == nullptr) return nullptr;
  const auto endpoint = remote->endpoints.find(guid.entity);
  return endpoint == remote->endpoints.end() ? nullptr : &endpoint->second;
}

// Who announces much takes no place from those who announce little.
bool Participant::has_room(Remote& remote, const RemoteEndpoint* known, std::size_t price) {
  const auto before = known == nullptr ? 0 : known->price;
  const auto of_it = remote.endpoint_octets - before + price;
  const auto of_all = endpoint_octets_ - before + price;
  const bool fits = of_it <= kMostEndpointOctetsPerParticipant && of_all <= kMostEndpointOctets &&
                    (known != nullptr || (remote.endpoints.size() < kMostEndpointsPerParticipant &&
                                          remote_endpoints_ < kMostEndpoints));
  if (fits || of_it <= kEndpointOctetsOfEach) return true;
  ++counters_.refused_discovery;
  if (!std::exchange(remote.exceeds, true))
    events_.raise(
        Event(Error(Code::rtps_too_many_endpoints,
                    {.found = fmt::format("{} endpoints of {} octets", remote.endpoints.size(),
                                          remote.endpoint_octets)}),
              {}, remote.data.guid.to_string()));
  return false;
}

void Participant::add_endpoint(Remote& remote, EndpointData data) {
  if (is_ignored(data)) return;
  const auto id = data.guid.entity;
  auto known = remote.endpoints.find(id);
  const auto price = kPricePerEndpoint + octets_of(data);
  if (!has_room(remote, known == remote.endpoints.end() ? nullptr : &known->second, price)) return;
  if (known != remote.endpoints.end() && known->second.data.topic_name != data.topic_name) {
    remove_endpoint(remote, id);
    known = remote.endpoints.end();
  }
  if (known == remote.endpoints.end()) {
    ++remote_endpoints_;
    topics_[data.topic_name].remotes.push_back(data.guid);
    known = remote.endpoints.try_emplace(id).first;
  }
  remote.endpoint_octets += price - known->second.price;
  endpoint_octets_ += price - known->second.price;
  known->second.price = price;
  auto& stored = known->second.data = std::move(data);
  if (discovery_ != nullptr) discovery_->on_endpoint(stored);
  const auto& ends = topics_[stored.topic_name];
  for (auto* local : ends.writers) match(*local, remote, stored);
  for (auto* local : ends.readers) match(*local, remote, stored);
}

template <class Local>
void Participant::forget(Local& local, const Guid& remote) {
  const auto keys = keys_of(local.data.guid.entity, remote);
  if (security_) security_->keyring().part(local.data.guid.entity, remote);
  if (std::erase(local.matched, remote) == 0) return;
  if constexpr (std::is_same_v<Local, LocalReader>) {
    if (auto* endpoint = find_remote(remote)) std::erase(endpoint->readers, local.protocol.get());
    local.protocol->unmatch(remote, keys);
  } else {
    std::erase(local.unready, remote);
    std::erase_if(readiness_, [&](const Readiness& r) {
      return r.writer == local.data.guid && r.reader == remote;
    });
    local.protocol->unmatch(remote);
  }
  local.listener->on_unmatched(remote);
}

template void Participant::forget(LocalWriter&, const Guid&);
template void Participant::forget(LocalReader&, const Guid&);

void Participant::remove_endpoint(Remote& remote, const EntityId& id) {
  const auto known = remote.endpoints.find(id);
  if (known == remote.endpoints.end()) return;
  const auto& data = known->second.data;
  const auto topic_name = data.topic_name;
  auto& ends = topics_[topic_name];
  for (auto* local : ends.writers) forget(*local, data.guid);
  for (auto* local : ends.readers) forget(*local, data.guid);
  if (!data.qos.liveliness.lease_duration.is_infinite())
    std::erase_if(remote.watches, [&](const auto& w) { return w.writer == data.guid; });
  std::erase(ends.remotes, data.guid);
  if (discovery_ != nullptr) discovery_->on_endpoint_gone(data);
  remote.endpoint_octets -= known->second.price;
  endpoint_octets_ -= known->second.price;
  remote.endpoints.erase(known);
  --remote_endpoints_;
  forget_if_empty(topic_name);
}

void Participant::forget_if_empty(const std::string& topic_name) {
  if (const auto at = topics_.find(topic_name); at != topics_.end() && at->second.empty())
    topics_.erase(at);
}

template <class Local>
void Participant::match_all(Local& local) {
  for (const auto& guid : topics_[local.data.topic_name].remotes) {
    auto& remote = remotes_.find(guid.prefix)->second;
    match(local, remote, remote.endpoints.find(guid.entity)->second.data);
  }
  if constexpr (std::is_same_v<Local, LocalWriter>)
    for (auto* reader : topics_[local.data.topic_name].readers) meet(local, *reader);
  else
    for (auto* writer : topics_[local.data.topic_name].writers) meet(*writer, local);
}
template void Participant::match_all(LocalWriter&);
template void Participant::match_all(LocalReader&);

Status Participant::change_qos(const Guid& endpoint, Qos qos, MonotonicTime now) {
  now_ = now;
  DDSSEC_TRY(check_consistency(qos));
  const auto apply = [&](auto& locals) {
    const auto local = locals.find(endpoint.entity);
    if (local == locals.end()) return;
    local->second.data.qos = qos;
    if constexpr (requires { local->second.protocol->hurry_as(qos); })
      local->second.protocol->hurry_as(qos);
    publish(local->second.data, now);
    match_all(local->second);
  };
  apply(writers_);
  apply(readers_);
  return {};
}

void Participant::change_filter(const Guid& reader, ContentFilterProperty filter,
                                MonotonicTime now) {
  const auto local = readers_.find(reader.entity);
  if (local == readers_.end()) return;
  local->second.data.content_filter = std::move(filter);
  publish(local->second.data, now);
}

std::optional<EndpointData> Participant::endpoint_on(const std::string& topic_name) const {
  const auto at = topics_.find(topic_name);
  if (at == topics_.end() || at->second.remotes.empty()) return std::nullopt;
  const auto& guid = at->second.remotes.front();
  return remotes_.find(guid.prefix)->second.endpoints.find(guid.entity)->second.data;
}

std::vector<Guid> Participant::matched(const Guid& endpoint) const {
  if (const auto at = writers_.find(endpoint.entity); at != writers_.end())
    return at->second.matched;
  if (const auto at = readers_.find(endpoint.entity); at != readers_.end())
    return at->second.matched;
  return {};
}

const EndpointData* Participant::remote_endpoint(const Guid& guid) {
  const auto* endpoint = find_remote(guid);
  return endpoint == nullptr ? nullptr : &endpoint->data;
}

void Participant::note_alive(const Remote& remote, LivelinessKind kind) {
  for (const auto& watch : remote.watches)
    if (watch.kind == kind) watch.listener->on_alive(watch.writer);
}

void Participant::note_alive(const GuidPrefix& from, const EntityId& writer) {
  const auto known = remotes_.find(from);
  const auto* remote = from == config_.prefix    ? &self_
                       : known == remotes_.end() ? nullptr
                                                 : &known->second;
  if (remote == nullptr || remote->watches.empty()) return;
  const auto* endpoint = remote_endpoint({from, writer});
  if (endpoint == nullptr) return;
  if (endpoint->qos.liveliness.kind == LivelinessKind::manual_by_participant)
    return note_alive(*remote, LivelinessKind::manual_by_participant);
  for (const auto& watch : remote->watches)
    if (watch.writer.entity == writer) watch.listener->on_alive(watch.writer);
}

// The same topic: then either a match, or an event and a status that say why not.
template <class Local>
bool Participant::compatible(Local& local, const EndpointData& remote, const Qos& offered,
                             const Qos& requested) {
  if (local.data.topic_name != remote.topic_name) return false;
  const auto refuse = [&](Code code, std::string field, std::string ours, std::string theirs,
                          std::string hint = {}) {
    events_.raise(Event(Error(code, {.document = "topic " + remote.topic_name,
                                     .field = std::move(field),
                                     .expected = std::move(ours),
                                     .found = std::move(theirs),
                                     .hint = std::move(hint)}),
                        {}, remote.guid.to_string()));
    return false;
  };
  const bool keyed = has_key(local.data.guid.entity);
  if (local.data.type_name != remote.type_name || keyed != has_key(remote.guid.entity))
    local.listener->on_inconsistent_topic(remote);
  if (local.data.type_name != remote.type_name)
    return refuse(Code::rtps_type_mismatch, "type", local.data.type_name, remote.type_name);
  if (keyed != has_key(remote.guid.entity))
    return refuse(Code::rtps_type_mismatch, "type", keyed ? "with key" : "without key",
                  keyed ? "without key" : "with key");
  const bool writes = is_writer(local.data.guid.entity);
  const auto& writer = writes ? local.data : remote;
  const auto& reader = writes ? remote : local.data;
  const auto types = judge_types(writer.type, reader.type, requested.type_consistency);
  if (!types.fits()) local.listener->on_inconsistent_topic(remote);
  if (!types.fits() && types.refused_by.empty())
    return refuse(Code::rtps_type_mismatch, "type",
                  describe_type(local.data.type_name, local.data.type),
                  describe_type(remote.type_name, remote.type));
  const auto why = types.fits() ? mismatch(offered, requested) : refusal(types, writer, reader);
  if (!why) return true;
  if (why->id != QosPolicyId::partition) local.listener->on_incompatible_qos(remote.guid, *why);
  return refuse(Code::rtps_qos_incompatible, why->policy, "requested " + why->requested,
                "offered " + why->offered, remedy(*why));
}

void Participant::match(LocalWriter& writer, Remote& remote, const EndpointData& data) {
  if (!is_reader(data.guid.entity)) return;
  bool keep = compatible(writer, data, writer.data.qos, data.qos);
  const bool ready = keep && introduce(writer.data.guid.entity, data, keep);
  if (!keep) return forget(writer, data.guid);
  if (!ready) return;
  // Who is fed in this process sees each sample, and filters itself.
  const bool near = neighbour(writer.data.guid.entity, data.guid) != nullptr;
  auto filter = data.content_filter && !near ? writer.listener->filter_for(data) : nullptr;
  const bool waits = shows_readiness(writer, data);
  if (std::ranges::find(writer.matched, data.guid) != writer.matched.end()) {
    writer.protocol->set_filter(data.guid, std::move(filter));
    const bool known = std::ranges::find(writer.unready, data.guid) == writer.unready.end();
    if (known) writer.listener->on_matched(data);
    return;
  }
  writer.matched.push_back(data.guid);
  if (waits) {
    writer.unready.push_back(data.guid);
    readiness_.push_back({writer.data.guid, data.guid, now_ + kReadiness});
  }
  const bool history = data.qos.durability >= DurabilityKind::transient_local;
  const auto locators =
      near ? LocatorList{} : usable_locators(data.unicast, remote.user, config_.interfaces);
  writer.protocol->match({data.guid, data.qos.is_reliable(), history, locators, near,
                          std::move(filter), key_reading_of(remote.data)},
                         now_);
  if (!waits) writer.listener->on_matched(data);
  join(writer.data.guid, data.guid);
}

// It says so by its first ACKNACK. A late joiner of a durable writer misses nothing.
bool Participant::shows_readiness(const LocalWriter& writer, const EndpointData& reader) const {
  return security_ && reader.guid.prefix != config_.prefix &&
         security_->own().attributes().is_rtps_protected() &&
         security_->is_authenticated(reader.guid.prefix) && reader.qos.is_reliable() &&
         writer.data.qos.is_reliable() &&
         std::min(writer.data.qos.durability, reader.qos.durability) == DurabilityKind::volatile_;
}

void Participant::note_ready(LocalWriter& writer, const Guid& reader) {
  if (std::erase(writer.unready, reader) == 0) return;
  std::erase_if(readiness_, [&](const Readiness& r) {
    return r.writer == writer.data.guid && r.reader == reader;
  });
  if (const auto* data = remote_endpoint(reader)) writer.listener->on_matched(*data);
}

void Participant::tick_readiness(MonotonicTime now) {
  while (!readiness_.empty() && readiness_.front().deadline <= now) {
    const auto due = readiness_.front();
    readiness_.pop_front();
    if (auto* writer = local_writer(due.writer.entity)) note_ready(*writer, due.reader);
  }
}

void Participant::match(LocalReader& reader, Remote& remote, const EndpointData& data) {
  if (!is_writer(data.guid.entity)) return;
  auto& matched = remote.endpoints.find(data.guid.entity)->second.readers;
  const bool known = std::ranges::find(matched, reader.protocol.get()) != matched.end();
  if (known)
    std::erase_if(remote.watches, [&](const auto& w) {
      return w.listener == reader.listener && w.writer == data.guid;
    });
  bool keep = compatible(reader, data, data.qos, reader.data.qos);
  const bool ready = keep && introduce(reader.data.guid.entity, data, keep);
  if (!keep) return forget(reader, data.guid);
  if (!ready) return;
  const auto& liveliness = data.qos.liveliness;
  if (!liveliness.lease_duration.is_infinite())
    remote.watches.push_back({reader.listener, data.guid, liveliness.kind});
  if (known) return reader.listener->on_matched(data);
  matched.push_back(reader.protocol.get());
  reader.matched.push_back(data.guid);
  const bool near = neighbour(reader.data.guid.entity, data.guid) != nullptr;
  const bool history =
      std::min(data.qos.durability, reader.data.qos.durability) >= DurabilityKind::transient_local;
  const auto locators =
      near ? LocatorList{} : usable_locators(data.unicast, remote.user, config_.interfaces);
  reader.protocol->match({data.guid, data.qos.is_reliable(), locators, near,
                          keys_of(reader.data.guid.entity, data.guid)},
                         now_, history);
  reader.listener->on_matched(data);
  join(reader.data.guid, data.guid);
}

}  // namespace ddssec::rtps
