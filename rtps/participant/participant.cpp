#include "rtps/participant/participant.hpp"

#include <algorithm>

namespace ddssec::rtps {

Participant::Participant(ParticipantConfig config, Transport& transport, EventSink& events)
    : config_(std::move(config)),
      events_(events),
      sender_(transport, config_.prefix),
      builtin_(config_.prefix, sender_, timers_,
               [this](BuiltinTopic topic, Change& change) { return on_builtin(topic, change); }),
      receiver_(config_.prefix, *this, *this, counters_, events_) {
  self_.data.guid = {config_.prefix, kEntityIdParticipant};
  sender_.fragment_at(config_.fragment_size);
}

Participant::~Participant() = default;

StatefulWriter* Participant::writer(const Guid& guid) {
  const auto at = writers_.find(guid.entity);
  return guid.prefix == config_.prefix && at != writers_.end() ? at->second.protocol.get()
                                                               : nullptr;
}

StatefulReader* Participant::reader(const Guid& guid) {
  const auto at = readers_.find(guid.entity);
  return guid.prefix == config_.prefix && at != readers_.end() ? at->second.protocol.get()
                                                               : nullptr;
}

void Participant::receive(BytesView datagram, MonotonicTime now) {
  now_ = now;
  const auto gathering = gather();
  receiver_.receive(datagram, now);
  for (const auto& prefix : std::exchange(gone_, {})) remove_remote(prefix);
}

std::span<StatefulReader* const> Participant::readers_of(const Guid& writer) {
  if (writer.entity == kVolatileMessageWriter) {
    volatile_reader_ = security_ ? security_->volatile_reader(writer.prefix) : nullptr;
    return {&volatile_reader_, volatile_reader_ == nullptr ? 0u : 1u};
  }
  if (is_builtin(writer.entity)) return builtin_.readers_of(writer.entity);
  auto* remote = find_remote(writer);
  if (remote == nullptr) return {};
  return remote->readers;
}

StatefulWriter* Participant::writer_for(const EntityId& writer, const GuidPrefix& reader) {
  if (writer == kVolatileMessageWriter)
    return security_ ? security_->volatile_writer(reader) : nullptr;
  if (is_builtin(writer)) return builtin_.find_writer(writer);
  auto* local = local_writer(writer);
  return local == nullptr ? nullptr : local->protocol.get();
}

void Participant::on_stateless(const GuidPrefix& source, BytesView payload) {
  if (security_) security_->on_stateless(source, payload, now_);
}

void Participant::on_stateless_frag(const GuidPrefix& source, const DataFrag& frag) {
  if (security_) security_->on_stateless_frag(source, frag, now_);
}

void Participant::on_builtin_heartbeat(const Guid& writer) {
  if (security_ && writer.entity == kParticipantsSecureWriter)
    note_participants_secure(writer.prefix);
}

void Participant::on_acknack(const EntityId& writer, const Guid& reader) {
  auto* local = local_writer(writer);
  if (local == nullptr) return;
  note_ready(*local, reader);
  local->listener->on_acknowledged();
}

void Participant::on_key_exchange(const GuidPrefix& source) {
  if (security_) security_->note_key_exchange(source);
}

// A participant that sends anything lives; in the name of an authenticated participant of a domain
// whose messages are protected, only protected messages (and announcements) say so.
void Participant::on_message(const GuidPrefix& source, bool is_protected) {
  const auto known = remotes_.find(source);
  if (known == remotes_.end()) return;
  const bool proven = is_protected || !security_ ||
                      !security_->own().attributes().is_rtps_protected() ||
                      !security_->is_authenticated(source);
  if (!proven) return;
  renew_lease(known->second, known->second.data, now_);
  note_alive(known->second, LivelinessKind::automatic);
}

Participant::LocalWriter* Participant::local_writer(const EntityId& id) {
  const auto at = writers_.find(id);
  return at == writers_.end() ? nullptr : &at->second;
}

void Participant::tick(MonotonicTime now) {
  now_ = now;
  if (now >= sender_.flush_by()) sender_.flush();
  const auto gathering = gather();
  if (std::exchange(reads_first_, false)) return;
  if (now >= next_announcement_) {
    constexpr int kFastAnnouncements = 6;
    announce(config_.announce_to);
    last_announcement_ = now;
    next_announcement_ =
        now + (++announcements_ < kFastAnnouncements ? kFastPeriod : announcement_period());
  }
  if (now >= next_liveliness_) assert_liveliness(LivelinessKind::automatic, now);
  tick_readiness(now);
  if (security_) security_->tick(now);
  timers_.run(now);
  remove_ended(now);
  for (const auto& prefix : std::exchange(gone_, {})) remove_remote(prefix);
}

MonotonicTime Participant::next_tick() const {
  const auto ready = readiness_.empty() ? kNever : readiness_.front().deadline;
  const auto next = std::min({next_announcement_, next_liveliness_, next_lease_, sender_.flush_by(),
                              timers_.next(), ready});
  return security_ ? std::min(next, security_->next_tick()) : next;
}

Guid Participant::create_group() {
  constexpr std::uint8_t kWriterGroup = 0x08;  // RTPS 9.3.1.2
  const auto number = next_entity_++;
  return {config_.prefix,
          EntityId{{static_cast<std::uint8_t>(number >> 16), static_cast<std::uint8_t>(number >> 8),
                    static_cast<std::uint8_t>(number), kWriterGroup}}};
}

EndpointData Participant::local_data(EndpointRequest request, EndpointKind kind) {
  const auto number = next_entity_++;
  EndpointData data;
  data.guid = {
      config_.prefix,
      EntityId{{static_cast<std::uint8_t>(number >> 16), static_cast<std::uint8_t>(number >> 8),
                static_cast<std::uint8_t>(number), static_cast<std::uint8_t>(kind)}}};
  data.topic_name = std::move(request.topic_name);
  data.type_name = std::move(request.type_name);
  data.qos = std::move(request.qos);
  data.type = std::move(request.type);
  data.content_filter = std::move(request.content_filter);
  data.group_guid = request.group;
  return data;
}

Status Participant::secure_endpoint(EndpointData& data, EndpointListener& listener) {
  const auto made = DDSSEC_TRY(security_->create_endpoint(
      data.guid.entity,
      {data.topic_name, data.qos.partition, data.qos.data_tags, data.qos.properties}));
  data.security_info = made.info;
  data.required_ciphers = made.required_ciphers;
  if (made.key_is_protected) listener.on_key_protected();
  return {};
}

Result<Guid> Participant::create_writer(EndpointRequest request, EndpointListener& listener,
                                        MonotonicTime now) {
  now_ = now;
  const auto gathering = gather();
  DDSSEC_TRY(check_consistency(request.qos));
  const auto kind = request.with_key ? EndpointKind::writer_with_key : EndpointKind::writer_no_key;
  auto history = std::move(request.history);
  const bool history_only = request.history_only;
  auto bare_key = std::move(request.bare_key);
  auto data = local_data(std::move(request), kind);
  const auto guid = data.guid;
  if (security_) DDSSEC_TRY(secure_endpoint(data, listener));
  auto protocol = std::make_unique<StatefulWriter>(guid, data.qos, sender_, &timers_);
  for (auto& change : history) protocol->write(std::move(change), now);
  if (history_only) protocol->serve_history_only();
  protocol->rewrite_keys_with(std::move(bare_key));
  protocol->on_acknowledged([&listener] { listener.on_acknowledged(); });
  auto& local = writers_[guid.entity] = {std::move(data), &listener, std::move(protocol), {}};
  topics_[local.data.topic_name].writers.push_back(&local);
  expect_liveliness_of(local.data.qos.liveliness, now);
  publish(local.data, now);
  match_all(local);
  return guid;
}

Result<Guid> Participant::create_reader(EndpointRequest request, EndpointListener& listener,
                                        MonotonicTime now) {
  now_ = now;
  const auto gathering = gather();
  DDSSEC_TRY(check_consistency(request.qos));
  const auto kind = request.with_key ? EndpointKind::reader_with_key : EndpointKind::reader_no_key;
  auto data = local_data(std::move(request), kind);
  const auto guid = data.guid;
  if (security_) DDSSEC_TRY(secure_endpoint(data, listener));
  auto protocol = std::make_unique<StatefulReader>(
      guid, data.qos.is_reliable(), sender_,
      [&listener](Change& change) { return listener.on_change(change); }, &timers_);
  protocol->on_lost([&listener](std::int64_t count) { listener.on_sample_lost(count); });
  protocol->on_dropped([&listener](const Guid& writer, std::uint32_t octets) {
    listener.on_sample_dropped(writer, octets);
  });
  if (data.qos.presentation.scope == PresentationScope::group)
    protocol->on_group([&listener](const Guid& writer, SequenceNumber group) {
      listener.on_group(writer, group);
    });
  protocol->on_alive([this](const Guid& writer) { note_alive(writer.prefix, writer.entity); });
  auto& local = readers_[guid.entity] = {std::move(data), &listener, std::move(protocol), {}};
  topics_[local.data.topic_name].readers.push_back(&local);
  publish(local.data, now);
  match_all(local);
  return guid;
}

template <class Local>
void Participant::take_off(Local& local, std::vector<Local*> TopicEnds::*where) {
  const auto& name = local.data.topic_name;
  std::erase(topics_[name].*where, &local);
  forget_if_empty(name);
}

void Participant::remove(const Guid& endpoint, MonotonicTime now) {
  now_ = now;
  const auto reader = readers_.find(endpoint.entity);
  const auto writer = writers_.find(endpoint.entity);
  if (reader != readers_.end()) {
    const auto is_its = [&](const auto& w) { return w.listener == reader->second.listener; };
    for (auto& [prefix, remote] : remotes_) std::erase_if(remote.watches, is_its);
    std::erase_if(self_.watches, is_its);
    for (const auto& guid : reader->second.matched)
      if (auto* remote = find_remote(guid))
        std::erase(remote->readers, reader->second.protocol.get());
    part_from(topics_[reader->second.data.topic_name].writers, endpoint);
    take_off(reader->second, &TopicEnds::readers);
    readers_.erase(reader);
    unpublish(endpoint, now);
  } else if (writer != writers_.end()) {
    part_from(topics_[writer->second.data.topic_name].readers, endpoint);
    take_off(writer->second, &TopicEnds::writers);
    writers_.erase(writer);
    unpublish(endpoint, now);
  }
  if (security_) security_->keyring().remove_local(endpoint.entity);
}

}  // namespace ddssec::rtps
