#include "rtps/participant/local_endpoints.hpp"

#include "rtps/discovery/serialized.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::rtps {

LocalEndpoints::LocalEndpoints(ParticipantCore& core, BuiltinEndpoints::Deliver deliver)
    : core_(core),
      builtin_(core.config.prefix, core.sender, core.timers, std::move(deliver)),
      next_entity_(core.config.first_entity) {}

EntityId LocalEndpoints::next_id(std::uint8_t kind) {
  const auto number = next_entity_++;
  return {{static_cast<std::uint8_t>(number >> 16), static_cast<std::uint8_t>(number >> 8),
           static_cast<std::uint8_t>(number), kind}};
}

Guid LocalEndpoints::create_group() {
  constexpr std::uint8_t kWriterGroup = 0x08;  // RTPS 9.3.1.2
  return {prefix(), next_id(kWriterGroup)};
}

EndpointData LocalEndpoints::data_of(EndpointDescription request, EndpointKind kind) {
  EndpointData data;
  data.guid = {prefix(), next_id(static_cast<std::uint8_t>(kind))};
  data.topic_name = std::move(request.topic_name);
  data.type_name = std::move(request.type_name);
  data.qos = std::move(request.qos);
  data.type = std::move(request.type);
  data.content_filter = std::move(request.content_filter);
  data.group_guid = request.group;
  return data;
}

Status LocalEndpoints::ask_access_control(EndpointData& data, EndpointListener& listener) {
  if (!core_.security) return {};
  DDSSEC_ASSIGN_OR_RETURN(
      const auto made,
      core_.security->create_endpoint(data.guid.entity, {data.topic_name, data.qos.partition,
                                                         data.qos.data_tags, data.qos.properties}));
  data.security_info = made.info;
  data.required_ciphers = made.required_ciphers;
  if (made.key_is_protected) listener.on_key_protected();
  const auto* attributes = core_.security->keyring().attributes(data.guid.entity);
  if (attributes != nullptr && attributes->is_payload_protected()) listener.on_payload_protected();
  return {};
}

Result<LocalWriter*> LocalEndpoints::create_writer(EndpointDescription request,
                                                   EndpointListener& listener) {
  DDSSEC_RETURN_IF_ERROR(check_consistency(request.qos));
  const auto kind = request.with_key ? EndpointKind::writer_with_key : EndpointKind::writer_no_key;
  auto history = std::move(request.history);
  const bool is_history_only = request.is_history_only;
  auto bare_key = std::move(request.bare_key);
  auto data = data_of(std::move(request), kind);
  DDSSEC_RETURN_IF_ERROR(ask_access_control(data, listener));
  auto protocol =
      std::make_unique<StatefulWriter>(data.guid, data.qos, core_.sender, &core_.timers);
  for (auto& change : history) protocol->write(std::move(change), core_.now);
  if (is_history_only) protocol->serve_history_only();
  protocol->rewrite_keys_with(std::move(bare_key));
  protocol->on_acknowledged([&listener] { listener.on_acknowledged(); });
  const auto id = data.guid.entity;
  return &(writers_[id] = {std::move(data), &listener, std::move(protocol), {}});
}

Result<LocalReader*> LocalEndpoints::create_reader(EndpointDescription request,
                                                   EndpointListener& listener) {
  DDSSEC_RETURN_IF_ERROR(check_consistency(request.qos));
  const auto kind = request.with_key ? EndpointKind::reader_with_key : EndpointKind::reader_no_key;
  auto held = std::move(request.held);
  auto data = data_of(std::move(request), kind);
  DDSSEC_RETURN_IF_ERROR(ask_access_control(data, listener));
  auto protocol = std::make_unique<StatefulReader>(
      data.guid, data.qos.is_reliable(), core_.sender,
      [&listener](Change& change) { return listener.on_change(change); }, &core_.timers);
  if (held) protocol->share_held(std::move(held));
  protocol->on_lost([&listener](std::int64_t count) { listener.on_sample_lost(count); });
  protocol->on_dropped([&listener](const Guid& writer, std::uint32_t octets) {
    listener.on_sample_dropped(writer, octets);
  });
  if (data.qos.presentation.scope == PresentationScope::group)
    protocol->on_group([&listener](const Guid& writer, SequenceNumber group) {
      listener.on_group(writer, group);
    });
  const auto id = data.guid.entity;
  return &(readers_[id] = {std::move(data), &listener, std::move(protocol), {}});
}

void LocalEndpoints::remove(const Guid& endpoint) {
  const auto& id = endpoint.entity;
  if (writers_.erase(id) + readers_.erase(id) > 0) unpublish(endpoint, is_announced_securely(id));
  if (moved_.erase(id) > 0) unpublish(endpoint, false);
  if (core_.security) core_.security->forget_endpoint(endpoint.entity);
}

void LocalEndpoints::publish_moved(const EndpointData& data) {
  publish(data);
  moved_.insert(data.guid.entity);
}

void LocalEndpoints::end_moves() {
  for (const auto& id : std::exchange(moved_, {})) unpublish({prefix(), id}, false);
}

void LocalEndpoints::publish(const EndpointData& data) {
  const bool securely = is_announced_securely(data.guid.entity);
  Change change;
  change.key_hash = data.guid.octets();
  if (data.qos.data_tags.empty() || securely) {
    change.payload = Payload::copy_of(serialized(data));
  } else {
    auto untagged = data;
    untagged.qos.data_tags.clear();
    change.payload = Payload::copy_of(serialized(untagged));
  }
  sedp_writer(data.guid.entity, securely).write(std::move(change), core_.now);
}

void LocalEndpoints::unpublish(const Guid& endpoint, bool securely) {
  std::array<std::uint8_t, 64> buffer;
  SpanWriter payload(buffer);
  write_endpoint_key(payload, endpoint);
  Change change;
  change.key_hash = endpoint.octets();
  change.status = {true, true};
  change.is_key_only = true;
  change.payload = Payload::copy_of(payload.view());
  sedp_writer(endpoint.entity, securely).write(std::move(change), core_.now);
}

// True if the endpoint is announced only to authenticated participants. The governance selects the
// topics (DDS-Security 1.2, clause 7.5.1.7).
bool LocalEndpoints::is_announced_securely(const EntityId& endpoint) const {
  const auto* attributes =
      core_.security ? core_.security->keyring().attributes(endpoint) : nullptr;
  return attributes != nullptr && attributes->topic.is_discovery_protected;
}

StatefulWriter& LocalEndpoints::sedp_writer(const EntityId& endpoint, bool securely) {
  if (is_writer(endpoint))
    return builtin_.writer(securely ? BuiltinTopic::publications_secure
                                    : BuiltinTopic::publications);
  return builtin_.writer(securely ? BuiltinTopic::subscriptions_secure
                                  : BuiltinTopic::subscriptions);
}

LocalWriter* LocalEndpoints::find_writer(const EntityId& id) {
  const auto at = writers_.find(id);
  return at == writers_.end() ? nullptr : &at->second;
}

const LocalWriter* LocalEndpoints::find_writer(const EntityId& id) const {
  const auto at = writers_.find(id);
  return at == writers_.end() ? nullptr : &at->second;
}

LocalReader* LocalEndpoints::find_reader(const EntityId& id) {
  const auto at = readers_.find(id);
  return at == readers_.end() ? nullptr : &at->second;
}

const EndpointData* LocalEndpoints::find(const EntityId& id) const {
  if (const auto at = writers_.find(id); at != writers_.end()) return &at->second.data;
  const auto at = readers_.find(id);
  return at == readers_.end() ? nullptr : &at->second.data;
}

void LocalEndpoints::note_key_change(const EntityId& local, const Guid& remote, KeyChange change) {
  const auto note_writer = [&](StatefulWriter& writer) {
    if (local.is_zero() || writer.guid().entity == local) writer.note_key_change(remote, change);
  };
  const auto note_reader = [&](StatefulReader& reader) {
    const auto& id = reader.guid().entity;
    if (local.is_zero() || id == local)
      reader.note_key_change(remote, change, core_.now,
                             [&](const Guid& writer) { return core_.keys_of(id, writer); });
  };
  // The change of one endpoint costs the same however many there are.
  if (auto* const writer = find_writer(local)) return note_writer(*writer->protocol);
  if (auto* const reader = find_reader(local)) return note_reader(*reader->protocol);
  if (local.is_zero()) {
    for (auto& [id, writer] : writers_) note_writer(*writer.protocol);
    for (auto& [id, reader] : readers_) note_reader(*reader.protocol);
  }
  builtin_.each([&](const BuiltinTopicInfo&, StatefulWriter& writer, StatefulReader& reader) {
    note_writer(writer);
    note_reader(reader);
  });
}

std::vector<Guid> LocalEndpoints::matched(const Guid& endpoint) const {
  if (const auto at = writers_.find(endpoint.entity); at != writers_.end())
    return at->second.matched.guids();
  if (const auto at = readers_.find(endpoint.entity); at != readers_.end())
    return at->second.matched.guids();
  return {};
}

bool LocalEndpoints::is_unprotected(const EntityId& endpoint) const {
  if (!core_.security) return true;
  const auto* attributes = core_.security->keyring().attributes(endpoint);
  return attributes != nullptr && !attributes->is_submessage_protected() &&
         !attributes->is_payload_protected() && !core_.attributes().is_rtps_protected();
}

StatefulWriter* LocalEndpoints::writer(const Guid& guid) const {
  const auto at = writers_.find(guid.entity);
  return guid.prefix == prefix() && at != writers_.end() ? at->second.protocol.get() : nullptr;
}

StatefulReader* LocalEndpoints::reader(const Guid& guid) const {
  const auto at = readers_.find(guid.entity);
  return guid.prefix == prefix() && at != readers_.end() ? at->second.protocol.get() : nullptr;
}

}  // namespace ddssec::rtps
