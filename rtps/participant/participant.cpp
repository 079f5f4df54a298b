#include "rtps/participant/participant.hpp"

#include <algorithm>

#include "wire/header_extension.hpp"
#include "wire/heartbeat_frag.hpp"
#include "wire/info_source.hpp"

namespace ddssec::rtps {

Participant::Participant(ParticipantConfig config, Transport& transport, EventSink& events)
    : config_(std::move(config)),
      events_(events),
      sender_(transport, config_.prefix),
      builtin_(config_.prefix, sender_, timers_,
               [this](BuiltinTopic topic, Change& change) { return on_builtin(topic, change); }) {
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
  ++counters_.messages;
  const auto header = read_header(datagram);
  Status status;
  if (!header) {
    status = std::unexpected(header.error());
  } else if (header->prefix != config_.prefix) {
    Context context{header->prefix, true, {}, now, datagram.size()};
    if (security_) {
      const auto opened =
          security_->keyring().open_message(*header, datagram, message_scratch_, now);
      if (!opened) return;  // counted, and said where it is worth an event
      datagram = opened->plain;
      context.shield.message = opened->by_participant;
    }
    status = walk(datagram, context);
    note_heard(context);
  }
  for (const auto& prefix : std::exchange(gone_, {})) remove_remote(prefix);
  if (status) return;
  ++counters_.malformed;
  events_.raise(Event(status.error(), {}, header ? header->prefix.to_string() : ""));
}

// RTPS 8.3.4.1: the first invalid submessage ends the message.
Status Participant::walk(BytesView octets, Context& context) {
  auto message = DDSSEC_TRY(MessageReader::open(octets));
  while (const auto view = DDSSEC_TRY(message.next())) {
    if (view->id == SubmessageId::secure_prefix && security_)
      DDSSEC_TRY(open_group(*view, message, context));
    else
      DDSSEC_TRY(process(*view, context));
  }
  return {};
}

// Prefix, one submessage and postfix (DDS-Security 7.4.6.2). What cannot be opened is dropped, what
// follows it counts.
Status Participant::open_group(const SubmessageView& prefix, MessageReader& message,
                               Context& context) {
  auto size = prefix.whole.size();
  for (int part = 0; part < 2; ++part) {
    const auto view = DDSSEC_TRY(message.next());
    if (!view) return fail(Code::truncated);
    size += view->whole.size();
  }
  if (!context.for_us) return {};
  const BytesView group(prefix.whole.data(), size);
  const auto opened =
      security_->keyring().open_submessage(context.source, group, submessage_scratch_);
  if (!opened) return {};
  const auto inner = DDSSEC_TRY(MessageReader::over_submessages({}, opened->plain).next());
  if (!inner) return fail(Code::truncated);
  context.shield.submessage = opened->by;
  const auto status = process(*inner, context);
  context.shield.submessage = {};
  if (opened->by.entity == kVolatileMessageWriter)
    wipe(MutableBytes(submessage_scratch_).first(opened->plain.size()));  // there were keys in it
  return status;
}

// Whoever sends anything lives; in the name of an authenticated participant of a domain whose
// messages are protected, only protected messages (and announcements) say so.
void Participant::note_heard(const Context& context) {
  const auto known = remotes_.find(context.source);
  if (known == remotes_.end()) return;
  const bool proven = context.shield.message || !security_ ||
                      !security_->own().attributes().is_rtps_protected() ||
                      !security_->is_authenticated(context.source);
  if (!proven) return;
  renew_lease(known->second, known->second.data, context.now);
  note_alive(known->second, LivelinessKind::automatic);
}

Status Participant::process_info(const SubmessageView& view, Context& context) {
  switch (view.id) {
    case SubmessageId::info_timestamp:
      context.time = DDSSEC_TRY(read_info_timestamp(view)).time;
      return {};
    case SubmessageId::info_source: {
      // Whose key protected the message has spoken for itself only.
      const auto source = DDSSEC_TRY(read_info_source(view)).source.prefix;
      context.shield.message = context.shield.message && source == context.source;
      context.source = source;
      context.time.reset();
      return {};
    }
    case SubmessageId::info_destination: {
      const auto destination = DDSSEC_TRY(read_info_destination(view)).prefix;
      context.for_us = destination.is_zero() || destination == config_.prefix;
      return {};
    }
    case SubmessageId::header_extension:
      DDSSEC_TRY(read_header_extension(view, context.message_size));
      return {};
    default:
      return {};  // INFO_REPLY, padding, vendors' own, protected ones we have no key for
  }
}

template <class F>
void Participant::each_reader(const EntityId& id, const EntityId& writer, const Context& context,
                              F&& f) {
  const Guid from{context.source, writer};
  const auto offer = [&](StatefulReader& reader) {
    const auto& own = reader.guid().entity;
    const bool meant = id == kEntityIdUnknown || id == own;
    if (meant && reader.is_matched(from) && accepts(own, from, context)) f(reader);
  };
  if (is_builtin(writer)) {
    builtin_.each([&](auto&, auto&, auto& reader) { offer(reader); });
    auto* keys = security_ ? security_->volatile_reader(context.source) : nullptr;
    if (keys != nullptr) offer(*keys);
    return;
  }
  if (auto* remote = find_remote(from))
    for (auto* local : remote->readers) offer(*local->protocol);
}

Status Participant::process(const SubmessageView& view, Context& context) {
  const auto& from = context.source;
  switch (view.id) {
    case SubmessageId::data:
      return on_data(view, context);
    case SubmessageId::data_frag:
      return on_data_frag(view, context);
    case SubmessageId::heartbeat: {
      const auto heartbeat = DDSSEC_TRY(read_heartbeat(view));
      if (!context.for_us) return {};
      if (security_ && heartbeat.writer == kParticipantsSecureWriter)
        note_participants_secure(from);
      each_reader(heartbeat.reader, heartbeat.writer, context, [&](auto& reader) {
        reader.on_heartbeat(from, heartbeat);
        if (heartbeat.asserts_liveliness) note_alive(from, heartbeat.writer);
      });
      return {};
    }
    case SubmessageId::gap: {
      const auto gap = DDSSEC_TRY(read_gap(view));
      if (context.for_us)
        each_reader(gap.reader, gap.writer, context,
                    [&](auto& reader) { reader.on_gap(from, gap); });
      return {};
    }
    case SubmessageId::heartbeat_frag: {
      DDSSEC_TRY(read_heartbeat_frag(view));  // the plain heartbeat behind it says enough
      return {};
    }
    case SubmessageId::acknack:
      return on_acknack(view, context);
    case SubmessageId::nack_frag:
      return on_nack_frag(view, context);
    default:
      return process_info(view, context);
  }
}

Status Participant::on_acknack(const SubmessageView& view, const Context& context) {
  const auto acknack = DDSSEC_TRY(read_acknack(view));
  auto* writer = addressed(acknack.writer, acknack.reader, context);
  if (writer == nullptr) return {};
  writer->on_acknack(context.source, acknack, context.now);
  auto* local = local_writer(acknack.writer);
  if (local == nullptr) return {};
  note_ready(*local, {context.source, acknack.reader});
  local->listener->on_acknowledged();
  return {};
}

Status Participant::on_nack_frag(const SubmessageView& view, const Context& context) {
  const auto nack = DDSSEC_TRY(read_nack_frag(view));
  auto* writer = addressed(nack.writer, nack.reader, context);
  if (writer != nullptr) writer->on_nack_frag(context.source, nack, context.now);
  return {};
}

Status Participant::on_data(const SubmessageView& view, const Context& context) {
  const auto data = DDSSEC_TRY(read_data(view));
  const auto& from = context.source;
  if (!context.for_us) return {};
  if (data.writer == kSpdpWriter) return on_spdp(data, context);
  if (data.writer == kStatelessMessageWriter) {
    if (security_) security_->on_stateless(from, data.payload, context.now);
    return {};
  }
  each_reader(data.reader, data.writer, context, [&](auto& reader) {
    auto plain = data;
    // The end of a coherent set has no payload; a GAP could say no less.
    const bool marker = data.payload.empty() && data.inline_qos.status == StatusInfo{};
    const auto payload = marker ? data.payload : opened(reader, {from, data.writer}, data.payload);
    if (!payload) return;
    plain.payload = *payload;
    sender_.note_sample();
    reader.on_data(from, plain, context.time);
    note_alive(from, data.writer);
  });
  return {};
}

Status Participant::on_data_frag(const SubmessageView& view, const Context& context) {
  const auto frag = DDSSEC_TRY(read_data_frag(view));
  const auto& from = context.source;
  if (!context.for_us) return {};
  if (frag.writer == kStatelessMessageWriter) {
    if (security_) security_->on_stateless_frag(from, frag, context.now);
    return {};
  }
  each_reader(frag.reader, frag.writer, context, [&](auto& reader) {
    const auto payload = opened(reader, {from, frag.writer}, frag.encoded);
    const auto plain = payload ? with_payload(frag, *payload) : fail(Code::truncated);
    if (!plain) return;
    reader.on_data_frag(from, *plain, context.time);
    note_alive(from, frag.writer);
  });
  return {};
}

std::optional<BytesView> Participant::opened(const StatefulReader& reader, const Guid& writer,
                                             BytesView payload) {
  if (!security_ || reader.guid().entity == kVolatileMessageReader) return payload;
  const auto plain =
      security_->keyring().open_payload(reader.guid().entity, writer, payload, payload_scratch_);
  return plain ? std::optional(*plain) : std::nullopt;
}

bool Participant::accepts(const EntityId& local, const Guid& remote, const Context& context) {
  if (!security_) return true;
  if (!security_->keyring().accepts(local, remote, context.shield)) return false;
  if (local == kVolatileMessageReader || local == kVolatileMessageWriter)
    security_->note_key_exchange(remote.prefix);
  return true;
}

StatefulWriter* Participant::addressed(const EntityId& writer, const EntityId& reader,
                                       const Context& context) {
  if (!context.for_us) return nullptr;
  auto* found = builtin_.find_writer(writer);
  if (found == nullptr && writer == kVolatileMessageWriter && security_)
    found = security_->volatile_writer(context.source);
  if (auto* local = local_writer(writer); found == nullptr && local != nullptr)
    found = local->protocol.get();
  const Guid from{context.source, reader};
  const bool good = found != nullptr && found->is_matched(from) && accepts(writer, from, context);
  return good ? found : nullptr;
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
      if (auto* remote = find_remote(guid)) std::erase(remote->readers, &reader->second);
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
