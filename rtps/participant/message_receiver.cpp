#include "rtps/participant/message_receiver.hpp"

#include "rtps/reliability/end_mark.hpp"
#include "rtps/security/mapped_memory.hpp"
#include "wire/header_extension.hpp"
#include "wire/heartbeat_frag.hpp"
#include "wire/info_source.hpp"

namespace ddssec::rtps {

MessageReceiver::MessageReceiver(const GuidPrefix& own, EndpointLookup& endpoints,
                                 MessageListener& listener, ParticipantCounters& counters,
                                 Report report)
    : own_(own),
      endpoints_(endpoints),
      listener_(listener),
      counters_(counters),
      report_(std::move(report)) {}

void MessageReceiver::open_with(Keyring& keyring) {
  constexpr std::size_t kScratch = 65536;  // the largest datagram, whatever part of it is protected
  keyring_ = &keyring;
  for (auto* scratch : {&message_scratch_, &submessage_scratch_, &payload_scratch_})
    scratch->resize(kScratch);
}

void MessageReceiver::receive(BytesView datagram, MonotonicTime now) {
  ++counters_.messages;
  const auto header = read_header(datagram);
  if (header) return read(*header, datagram, now);
  ++counters_.malformed;
  report_({}, header.error(), EventOrigin::anyone);
}

void MessageReceiver::read(const Header& header, BytesView datagram, MonotonicTime now) {
  if (header.prefix == own_) return;
  Context context{.source = header.prefix, .now = now, .message_size = datagram.size()};
  if (keyring_ != nullptr) {
    const auto opened = keyring_->open_message(header, datagram, message_scratch_, now);
    if (!opened) return;  // counted, and reported if it deserves an event
    datagram = opened->plain;
    context.opened_by.message = opened->is_by_participant;
    context.opened_by.message_key = opened->age;
  }
  const auto status = walk(datagram, context);
  report(context);
  if (status) return;
  ++counters_.malformed;
  const bool by_keys = context.opened_by.message || context.opened_by.submessage != Guid{};
  report_(by_keys ? context.source : header.prefix, status.error(),
          by_keys ? EventOrigin::its_keys : EventOrigin::anyone);
}

void MessageReceiver::report(Context& context) {
  listener_.on_message(context.source, context.signs);
  context.signs = {.is_directed = context.signs.is_directed};
}

// The first invalid submessage ends the message (RTPS 8.3.4.1).
Status MessageReceiver::walk(BytesView octets, Context& context) {
  DDSSEC_ASSIGN_OR_RETURN(auto message, MessageReader::open(octets));
  while (true) {
    DDSSEC_ASSIGN_OR_RETURN(const auto view, message.next());
    if (!view) break;

    if (view->id == SubmessageId::secure_prefix && keyring_ != nullptr)
      DDSSEC_RETURN_IF_ERROR(open_group(*view, message, context));
    else
      DDSSEC_RETURN_IF_ERROR(process(*view, context));
  }
  return {};
}

// Reads a prefix, one submessage and a postfix (DDS-Security 1.2, clause 7.4.6.4). If they cannot
// be opened, they are dropped; the submessages after them still count.
Status MessageReceiver::open_group(const SubmessageView& prefix, MessageReader& message,
                                   Context& context) {
  auto size = prefix.whole.size();
  for (int part = 0; part < 2; ++part) {
    DDSSEC_ASSIGN_OR_RETURN(const auto view, message.next());
    if (!view) return fail(Code::truncated);
    size += view->whole.size();
  }
  if (!context.counts()) return {};
  const BytesView group(prefix.whole.data(), size);
  const auto opened = keyring_->open_submessage(context.source, group, submessage_scratch_);
  if (!opened) return {};
  context.opened_by.submessage = opened->by;
  context.opened_by.protection = opened->protection;
  context.opened_by.submessage_key = opened->age;
  DDSSEC_ASSIGN_OR_RETURN(const auto inner,
                          MessageReader::over_submessages({}, opened->plain).next());
  if (!inner) return fail(Code::truncated);
  const auto status = process(*inner, context);
  if (status) context.opened_by.submessage = {};  // otherwise the message ends with this submessage
  if (opened->by.entity == kVolatileMessageWriter)
    wipe(MutableBytes(submessage_scratch_).first(opened->plain.size()));  // it contained keys
  return status;
}

Status MessageReceiver::process(const SubmessageView& view, Context& context) {
  switch (view.id) {
    case SubmessageId::data:
      return on_data(view, context);
    case SubmessageId::data_frag:
      return on_data_frag(view, context);
    case SubmessageId::heartbeat:
      return on_heartbeat(view, context);
    case SubmessageId::gap:
      return on_gap(view, context);
    case SubmessageId::heartbeat_frag: {
      DDSSEC_RETURN_IF_ERROR(
          read_heartbeat_frag(view));  // the HEARTBEAT after it carries enough information
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

Status MessageReceiver::process_info(const SubmessageView& view, Context& context) {
  switch (view.id) {
    case SubmessageId::info_timestamp: {
      DDSSEC_ASSIGN_OR_RETURN(const auto info_timestamp, read_info_timestamp(view));
      context.time = info_timestamp.time;
      return {};
    }
    case SubmessageId::info_source: {
      // A key that protected the message proves only its owner as source. The submessages before do
      // not show that another participant is alive.
      DDSSEC_ASSIGN_OR_RETURN(auto info_source, read_info_source(view));
      const auto source = std::move(info_source).source.prefix;
      if (source != context.source) report(context);
      context.opened_by.message = context.opened_by.message && source == context.source;
      context.source = source;
      context.is_from_us = source == own_;
      context.time.reset();
      return {};
    }
    case SubmessageId::info_destination: {
      DDSSEC_ASSIGN_OR_RETURN(const auto info_destination, read_info_destination(view));
      const auto destination = info_destination.prefix;
      context.is_for_us = destination.is_zero() || destination == own_;
      context.signs.is_directed |= destination == own_;
      return {};
    }
    case SubmessageId::header_extension:
      DDSSEC_RETURN_IF_ERROR(read_header_extension(view, context.message_size));
      return {};
    default:
      return {};  // INFO_REPLY, padding, vendor-specific, or protected without a key for it
  }
}

template <class F>
void MessageReceiver::each_reader(const EntityId& id, const EntityId& writer,
                                  const Context& context, F&& f) {
  const Guid from{context.source, writer};
  for (auto* reader : endpoints_.readers_of(from)) {
    const auto& own = reader->guid().entity;
    const bool meant = id == kEntityIdUnknown || id == own;
    if (meant && reader->writer(from) != nullptr && accepts(own, from, context)) f(*reader);
  }
}

StatefulWriter* MessageReceiver::addressed(const EntityId& writer, const EntityId& reader,
                                           const Context& context) {
  if (!context.counts()) return nullptr;
  auto* found = endpoints_.writer_for(writer, context.source);
  const Guid from{context.source, reader};
  // A reader that no longer matches because it was silent may be heard again.
  const bool may_speak =
      found != nullptr && (found->readers().contains(from) || !is_builtin(writer));
  return may_speak && accepts(writer, from, context) ? found : nullptr;
}

bool MessageReceiver::accepts(const EntityId& local, const Guid& remote, const Context& context) {
  if (keyring_ == nullptr) return true;
  if (!keyring_->accepts(local, remote, context.opened_by)) return false;
  if (local == kVolatileMessageReader || local == kVolatileMessageWriter)
    listener_.on_key_exchange(remote.prefix);
  return true;
}

// What a reader said to another participant has counts that may be far ahead of those that it sends
// to this one. HEARTBEATs need no such check: the counts of a writer are the same for all readers.
bool MessageReceiver::is_for(const EntityId& writer, const EntityId& reader,
                             const Context& context) const {
  return context.is_protected() &&
         shows_receiver(*keyring_, writer, {context.source, reader}, context.opened_by);
}

bool MessageReceiver::is_marked(const EntityId& reader, const Guid& writer,
                                const Context& context) {
  return keyring_ != nullptr &&
         is_only_payload_proven(*keyring_, reader, writer, context.opened_by) &&
         endpoints_.marks_ends(writer.prefix);
}

// The end of a coherent set has no payload. It counts, because it reports no more than a GAP could.
bool MessageReceiver::is_refused(const EntityId& reader, const Guid& writer, const Data& plain,
                                 const Context& context) {
  const auto& status = plain.inline_qos.status;
  if (!plain.payload.empty()) {
    const auto mark = end_mark(status, plain.kind == PayloadKind::key);
    if (!is_marked(reader, writer, context) || has_end_mark(plain.payload, mark)) return false;
    keyring_->note_unproven_end(reader, writer, "the payload of another message");
    return true;
  }
  if (status == StatusInfo{} || keyring_ == nullptr || !endpoints_.sends_keys(writer.prefix) ||
      !is_only_payload_proven(*keyring_, reader, writer, context.opened_by))
    return false;
  keyring_->note_unproven_end(reader, writer, "a dispose or unregister without a payload");
  return true;
}

// Submessage protection does not cover INFO_TS, so an attacker can change it.
std::optional<Time> MessageReceiver::source_time(const Context& context,
                                                 const InlineQos& inline_qos) const {
  const auto& by_writer = context.opened_by.submessage;
  const bool is_covered = context.opened_by.message || by_writer.prefix != context.source;
  if (is_covered || is_builtin(by_writer.entity) || !endpoints_.sends_keys(context.source))
    return context.time;
  return inline_qos.source_time;
}

std::optional<BytesView> MessageReceiver::opened(const StatefulReader& reader, const Guid& writer,
                                                 BytesView payload,
                                                 const ReceivedProtection& opened_by) {
  if (keyring_ == nullptr || reader.guid().entity == kVolatileMessageReader) return payload;
  const auto plain =
      keyring_->open_payload(reader.guid().entity, writer, payload, opened_by, payload_scratch_);
  return plain ? std::optional(*plain) : std::nullopt;
}

Status MessageReceiver::on_data(const SubmessageView& view, Context& context) {
  DDSSEC_ASSIGN_OR_RETURN(const auto data, read_data(view));
  const auto& from = context.source;
  if (!context.counts()) return {};
  if (data.writer == kSpdpWriter) return listener_.on_announcement(from, data);
  if (data.writer == kStatelessMessageWriter) {
    listener_.on_stateless(from, data.payload);
    return {};
  }
  // A writer of another vendor may give the number of the parameter another meaning.
  const bool is_elsewhere = data.inline_qos.memory && memory_ != nullptr &&
                            memory_->has_writer({context.source, data.writer});
  if (is_elsewhere) return on_reference(data, context);
  each_reader(data.reader, data.writer, context, [&](StatefulReader& reader) {
    auto plain = data;
    const bool marker = data.payload.empty() && data.inline_qos.status == StatusInfo{};
    const auto payload = marker
                             ? data.payload
                             : opened(reader, {from, data.writer}, data.payload, context.opened_by);
    if (!payload) return;
    plain.payload = *payload;
    if (is_refused(reader.guid().entity, {from, data.writer}, plain, context)) return;
    if (!reader.on_data(from, plain, source_time(context, data.inline_qos), {},
                        context.opened_by.age()))
      return;
    context.note_received(true);
    listener_.on_alive({from, data.writer});
    if (memory_ != nullptr)
      memory_->note_message({from, data.writer}, plain.payload.size(), context.now);
  });
  return {};
}

// If the payload cannot be fetched, the sample counts as not arrived: a reliable reader requests
// it, and gets it in messages.
Status MessageReceiver::on_reference(const Data& data, Context& context) {
  const Guid writer{context.source, data.writer};
  const bool is_sample = data.payload.empty() && data.inline_qos.status == StatusInfo{};
  if (!is_sample) return {};
  Payload fetched;
  each_reader(data.reader, data.writer, context, [&](StatefulReader& reader) {
    if (!reader.writer(writer)->lacks(data.sequence_number)) return;
    if (fetched.size() == 0) fetched = memory_->fetch(writer, *data.inline_qos.memory, context.now);
    if (fetched.size() == 0) return;
    auto payload = opened(reader, writer, fetched, context.opened_by);
    const bool ends =
        is_marked(reader.guid().entity, writer, context) && !has_end_mark(payload.view(), 0);
    if (payload.size() == 0 || ends ||
        !reader.on_data(writer.prefix, data, source_time(context, data.inline_qos),
                        std::move(payload), context.opened_by.age()))
      return;
    context.note_received(true);
    listener_.on_alive(writer);
  });
  return {};
}

Payload MessageReceiver::opened(const StatefulReader& reader, const Guid& writer,
                                const Payload& payload, const ReceivedProtection& opened_by) {
  auto out = Payload::uninitialized(payload.size());
  const auto plain =
      keyring_->open_payload(reader.guid().entity, writer, payload.view(), opened_by, out.fill());
  if (!plain) return {};
  if (plain->data() == payload.view().data()) return payload;  // it was not protected
  out.shrink(plain->size());
  return out;
}

Status MessageReceiver::on_data_frag(const SubmessageView& view, Context& context) {
  DDSSEC_ASSIGN_OR_RETURN(const auto frag, read_data_frag(view));
  const auto& from = context.source;
  if (!context.counts()) return {};
  if (frag.writer == kStatelessMessageWriter) {
    listener_.on_stateless_frag(from, frag);
    return {};
  }
  each_reader(frag.reader, frag.writer, context, [&](StatefulReader& reader) {
    const auto payload = opened(reader, {from, frag.writer}, frag.encoded, context.opened_by);
    const auto plain = payload ? with_payload(frag, *payload) : fail(Code::truncated);
    if (!plain) return;
    const bool marks = is_marked(reader.guid().entity, {from, frag.writer}, context);
    if (!reader.on_data_frag(from, *plain, source_time(context, frag.inline_qos), marks,
                             context.opened_by.age()))
      return;
    context.note_received(true);
    listener_.on_alive({from, frag.writer});
    if (memory_ != nullptr)
      memory_->note_message({from, frag.writer}, frag.sample_size, context.now);
  });
  return {};
}

Status MessageReceiver::on_heartbeat(const SubmessageView& view, Context& context) {
  DDSSEC_ASSIGN_OR_RETURN(const auto heartbeat, read_heartbeat(view));
  const Guid from{context.source, heartbeat.writer};
  if (!context.counts()) return {};
  if (is_builtin(heartbeat.writer)) listener_.on_builtin_heartbeat(from);
  each_reader(heartbeat.reader, heartbeat.writer, context, [&](StatefulReader& reader) {
    if (!reader.on_heartbeat(from.prefix, heartbeat, context.is_protected(),
                             context.opened_by.age()))
      return;
    context.note_received(true);
    if (heartbeat.asserts_liveliness) listener_.on_alive(from);
  });
  return {};
}

Status MessageReceiver::on_gap(const SubmessageView& view, Context& context) {
  DDSSEC_ASSIGN_OR_RETURN(const auto gap, read_gap(view));
  if (!context.counts()) return {};
  each_reader(gap.reader, gap.writer, context, [&](StatefulReader& reader) {
    context.note_received(reader.on_gap(context.source, gap, context.opened_by.age()));
  });
  return {};
}

Status MessageReceiver::on_acknack(const SubmessageView& view, Context& context) {
  DDSSEC_ASSIGN_OR_RETURN(const auto acknack, read_acknack(view));
  auto* writer = addressed(acknack.writer, acknack.reader, context);
  if (writer == nullptr) return {};
  const bool is_protected = is_for(acknack.writer, acknack.reader, context);
  const bool is_new = writer->on_acknack(context.source, acknack, context.now, is_protected,
                                         context.opened_by.age());
  context.note_received(is_new, is_protected);
  context.signs.is_lasting_proof |=
      is_new && is_protected && acknack.writer == kVolatileMessageWriter;
  listener_.on_acknack(context.source, acknack, is_protected);
  return {};
}

Status MessageReceiver::on_nack_frag(const SubmessageView& view, Context& context) {
  DDSSEC_ASSIGN_OR_RETURN(const auto nack, read_nack_frag(view));
  auto* writer = addressed(nack.writer, nack.reader, context);
  if (writer == nullptr) return {};
  const bool is_protected = is_for(nack.writer, nack.reader, context);
  context.note_received(writer->on_nack_frag(context.source, nack, context.now, is_protected,
                                             context.opened_by.age()),
                        is_protected);
  return {};
}

}  // namespace ddssec::rtps
