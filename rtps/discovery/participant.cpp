#include "rtps/discovery/participant.hpp"

#include <algorithm>

#include "rtps/wire/header_extension.hpp"
#include "rtps/wire/heartbeat_frag.hpp"
#include "rtps/wire/info_source.hpp"

namespace ddssec::rtps {
namespace {

// RTPS 8.5.4: the builtin writers of SEDP keep the last announcement of each endpoint.
Qos builtin_qos() {
  auto qos = default_writer_qos();
  qos.durability = DurabilityKind::transient_local;
  return qos;
}

}  // namespace

Participant::Participant(ParticipantConfig config, Transport& transport, EventSink& events)
    : config_(std::move(config)),
      events_(events),
      sender_(transport, config_.prefix),
      publications_writer_({config_.prefix, kPublicationsWriter}, builtin_qos(), sender_),
      subscriptions_writer_({config_.prefix, kSubscriptionsWriter}, builtin_qos(), sender_),
      publications_reader_({config_.prefix, kPublicationsReader}, true, sender_,
                           [this](Change& change) { return on_sedp(change, true); }),
      subscriptions_reader_({config_.prefix, kSubscriptionsReader}, true, sender_,
                            [this](Change& change) { return on_sedp(change, false); }) {}

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
  ++counters_.messages;
  auto message = MessageReader::open(datagram);
  Status status;
  if (!message) {
    status = std::unexpected(message.error());
  } else if (message->header().prefix != config_.prefix) {
    Context context{message->header().prefix, true, {}, now, datagram.size()};
    // RTPS 8.3.4.1: the first invalid submessage ends the message.
    for (;;) {
      const auto next = message->next();
      if (!next) status = std::unexpected(next.error());
      if (!next || !*next) break;
      status = process(**next, context);
      if (!status) break;
    }
    if (const auto known = remotes_.find(message->header().prefix); known != remotes_.end()) {
      known->second.lease_end = lease_end(known->second.data, now);
      note_alive(known->second, LivelinessKind::automatic);
    }
  }
  if (status) return;
  ++counters_.malformed;
  events_.raise(Event(status.error(), {}, message ? message->header().prefix.to_string() : ""));
}

Status Participant::process_info(const SubmessageView& view, Context& context) {
  switch (view.id) {
    case SubmessageId::info_timestamp:
      context.time = DDSSEC_TRY(read_info_timestamp(view)).time;
      return {};
    case SubmessageId::info_source:
      context.source = DDSSEC_TRY(read_info_source(view)).source.prefix;
      context.time.reset();
      return {};
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
      each_reader(heartbeat.reader, [&](auto& reader) { reader.on_heartbeat(from, heartbeat); });
      if (heartbeat.asserts_liveliness) note_alive(from, heartbeat.writer);
      return {};
    }
    case SubmessageId::gap: {
      const auto gap = DDSSEC_TRY(read_gap(view));
      if (context.for_us) each_reader(gap.reader, [&](auto& reader) { reader.on_gap(from, gap); });
      return {};
    }
    case SubmessageId::heartbeat_frag: {
      DDSSEC_TRY(read_heartbeat_frag(view));  // the plain heartbeat behind it says enough
      return {};
    }
    case SubmessageId::acknack: {
      const auto acknack = DDSSEC_TRY(read_acknack(view));
      if (!context.for_us) return {};
      if (acknack.writer == kPublicationsWriter)
        publications_writer_.on_acknack(from, acknack, context.now);
      else if (acknack.writer == kSubscriptionsWriter)
        subscriptions_writer_.on_acknack(from, acknack, context.now);
      else if (auto* local = local_writer(acknack.writer)) {
        local->protocol->on_acknack(from, acknack, context.now);
        local->listener->on_acknowledged();
      }
      return {};
    }
    case SubmessageId::nack_frag: {
      const auto nack = DDSSEC_TRY(read_nack_frag(view));
      auto* local = context.for_us ? local_writer(nack.writer) : nullptr;
      if (local != nullptr) local->protocol->on_nack_frag(from, nack, context.now);
      return {};
    }
    default:
      return process_info(view, context);
  }
}

Status Participant::on_data(const SubmessageView& view, const Context& context) {
  const auto data = DDSSEC_TRY(read_data(view));
  if (!context.for_us) return {};
  if (data.writer == kSpdpWriter) return on_spdp(data, context);
  each_reader(data.reader,
              [&](auto& reader) { reader.on_data(context.source, data, context.time); });
  note_alive(context.source, data.writer);
  return {};
}

Status Participant::on_data_frag(const SubmessageView& view, const Context& context) {
  const auto frag = DDSSEC_TRY(read_data_frag(view));
  if (!context.for_us) return {};
  each_reader(frag.reader,
              [&](auto& reader) { reader.on_data_frag(context.source, frag, context.time); });
  note_alive(context.source, frag.writer);
  return {};
}

// A reader drops what comes from a writer that it did not match, so that asking all is safe.
void Participant::each_reader(const EntityId& id, const std::function<void(StatefulReader&)>& f) {
  if (id == kEntityIdUnknown || id == kPublicationsReader) f(publications_reader_);
  if (id == kEntityIdUnknown || id == kSubscriptionsReader) f(subscriptions_reader_);
  for (auto& [own, local] : readers_)
    if (id == kEntityIdUnknown || id == own) f(*local.protocol);
}

Participant::LocalWriter* Participant::local_writer(const EntityId& id) {
  const auto at = writers_.find(id);
  return at == writers_.end() ? nullptr : &at->second;
}

void Participant::tick(MonotonicTime now) {
  now_ = now;
  if (now >= next_announcement_) {
    constexpr int kFastAnnouncements = 6;
    announce(config_.announce_to);
    next_announcement_ =
        now + (++announcements_ < kFastAnnouncements ? std::chrono::milliseconds(100)
                                                     : std::chrono::milliseconds(3000));
  }
  for (auto* builtin : {&publications_writer_, &subscriptions_writer_}) builtin->tick(now);
  for (auto* builtin : {&publications_reader_, &subscriptions_reader_}) builtin->tick(now);
  for (auto& [id, local] : writers_) local.protocol->tick(now);
  for (auto& [id, local] : readers_) local.protocol->tick(now);
  std::vector<GuidPrefix> ended;
  for (const auto& [prefix, remote] : remotes_)
    if (remote.lease_end <= now) ended.push_back(prefix);
  for (const auto& prefix : ended) remove_remote(prefix);
}

MonotonicTime Participant::next_tick() const {
  auto next = next_announcement_;
  next = std::min({next, publications_writer_.next_tick(), subscriptions_writer_.next_tick(),
                   publications_reader_.next_tick(), subscriptions_reader_.next_tick()});
  for (const auto& [id, local] : writers_) next = std::min(next, local.protocol->next_tick());
  for (const auto& [id, local] : readers_) next = std::min(next, local.protocol->next_tick());
  for (const auto& [prefix, remote] : remotes_) next = std::min(next, remote.lease_end);
  return next;
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
  return data;
}

Result<Guid> Participant::create_writer(EndpointRequest request, EndpointListener& listener,
                                        MonotonicTime now) {
  now_ = now;
  DDSSEC_TRY(check_consistency(request.qos));
  const auto kind = request.with_key ? EndpointKind::writer_with_key : EndpointKind::writer_no_key;
  auto data = local_data(std::move(request), kind);
  const auto guid = data.guid;
  auto protocol = std::make_unique<StatefulWriter>(guid, data.qos, sender_);
  auto& local = writers_[guid.entity] = {std::move(data), &listener, std::move(protocol), {}};
  publish(local.data, now);
  match_all(local);
  return guid;
}

Result<Guid> Participant::create_reader(EndpointRequest request, EndpointListener& listener,
                                        MonotonicTime now) {
  now_ = now;
  DDSSEC_TRY(check_consistency(request.qos));
  const auto kind = request.with_key ? EndpointKind::reader_with_key : EndpointKind::reader_no_key;
  auto data = local_data(std::move(request), kind);
  const auto guid = data.guid;
  auto protocol = std::make_unique<StatefulReader>(
      guid, data.qos.is_reliable(), sender_,
      [&listener](Change& change) { return listener.on_change(change); });
  protocol->on_lost([&listener](std::int64_t count) { listener.on_sample_lost(count); });
  auto& local = readers_[guid.entity] = {std::move(data), &listener, std::move(protocol), {}};
  publish(local.data, now);
  match_all(local);
  return guid;
}

void Participant::remove(const Guid& endpoint, MonotonicTime now) {
  now_ = now;
  if (const auto reader = readers_.find(endpoint.entity); reader != readers_.end())
    for (auto& [prefix, remote] : remotes_)
      std::erase_if(remote.watches,
                    [&](const auto& w) { return w.listener == reader->second.listener; });
  if (writers_.erase(endpoint.entity) + readers_.erase(endpoint.entity) > 0)
    unpublish(endpoint, now);
}

}  // namespace ddssec::rtps
