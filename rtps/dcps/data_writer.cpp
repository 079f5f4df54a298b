#include "rtps/dcps/data_writer.hpp"

#include <fmt/format.h>

#include "rtps/dcps/count_status.hpp"
#include "rtps/dcps/domain_participant.hpp"
#include "rtps/dcps/participant_parts.hpp"
#include "rtps/dcps/writer_filter.hpp"
#include "rtps/durability/durable_stores.hpp"
#include "rtps/participant/rtps_participant.hpp"

namespace ddssec::rtps {
namespace {

constexpr std::chrono::nanoseconds kBrake = std::chrono::milliseconds(20);

std::unexpected<Error> bad_parameter_error(std::string field, std::string expected,
                                           std::string found) {
  return fail(Code::rtps_bad_parameter, {.document = "writer",
                                         .field = std::move(field),
                                         .expected = std::move(expected),
                                         .found = std::move(found)});
}

// Readers drop larger samples, and the writer would not notice.
Status check_size(const std::string& topic, std::size_t size) {
  if (size <= StatefulReader::kMaxSample) return {};
  return fail(Code::rtps_sample_too_large,
              {.document = "writer of topic " + topic,
               .field = "serialized size",
               .expected = "at most " + std::to_string(StatefulReader::kMaxSample),
               .found = std::to_string(size)});
}

// If readers hold up the writer, names the one that has acknowledged least. A writer that keeps
// what is acknowledged, for late joiners, waits for no reader.
Error history_full_error(const StatefulWriter& writer, const ParticipantCore& participant) {
  const auto document = "writer " + writer.guid().to_string();
  const ReaderProxy* last = nullptr;
  for (const auto& [guid, proxy] : writer.readers().all())
    if (proxy.acknowledges() && (last == nullptr || proxy.acknowledged() < last->acknowledged()))
      last = &proxy;
  if (last == nullptr || writer.qos().durability >= DurabilityKind::transient_local)
    return {Code::rtps_history_full, {.document = document}};
  const auto& reader = last->reader().guid;
  const auto subject = participant.subject_of(reader.prefix);
  return {
      Code::rtps_history_full,
      {.document = document,
       .expected = fmt::format("an acknowledgment up to sample {}", writer.history().first().value),
       .found = fmt::format("reader {}{} has acknowledged up to {}", reader.to_string(),
                            subject.empty() ? "" : " of " + subject, last->acknowledged().value)}};
}

}  // namespace

StatefulWriter& AnyDataWriter::protocol() const {
  return *context_.protocol().local_endpoints().writer(guid_);
}

AnyDataWriter::AnyDataWriter(Group& publisher, ParticipantContext& context, Topic& topic, Qos qos)
    : Endpoint(publisher, context, topic, std::move(qos),
               {"writer", "publisher", StatusKind::publication_matched,
                StatusKind::offered_incompatible_qos, StatusKind::offered_deadline_missed}),
      TimedObject(context.timers()),
      version_(version_of(qos_)),
      listeners_(this->publisher().listening_, publisher.participant().listening_),
      instances_(qos_),
      liveliness_(context.timers(), publisher.participant().parts_->manual_liveliness, [this] {
        add_to(liveliness_lost_);
        changes_.note(StatusKind::liveliness_lost);
      }) {}

AnyDataWriter::~AnyDataWriter() { retire(); }

void AnyDataWriter::on_retired() {
  cancel();
  liveliness_.stop();
}

Publisher& AnyDataWriter::publisher() const { return static_cast<Publisher&>(group_); }

Result<Guid> AnyDataWriter::create(EndpointDescription request) {
  const auto now = context_.now();
  if (qos_.durability >= DurabilityKind::transient) DDSSEC_RETURN_IF_ERROR(restore(request));
  request.group = publisher().group_guid();
  request.bare_key = topic_.type().bare_key;
  const auto guid = context_.protocol().create_writer(std::move(request), *this, now);
  if (guid) publisher().admit(*context_.protocol().local_endpoints().writer(*guid));
  if (guid) liveliness_.start(qos_.liveliness, now);
  if (guid) call_at(next_work(now));
  return guid;
}

Status AnyDataWriter::restore(EndpointDescription& request) {
  auto& participant = publisher().participant();
  DDSSEC_ASSIGN_OR_RETURN(auto* store, participant.parts_->stores.of(qos_.durability));
  StreamKey key{.domain = static_cast<std::uint32_t>(participant.domain_id()),
                .topic = request.topic_name,
                .type = request.type_name,
                .partition = request.qos.partition};
  DDSSEC_ASSIGN_OR_RETURN(auto opened,
                          durability_.open(*store, std::move(key), request.qos.durability_service,
                                           context_.moment(), qos_.lifespan));
  for (std::size_t i = 0; i < opened.history.size(); ++i) {
    auto& change = opened.history[i];
    instances_->enter(change.key_hash.value_or(KeyHash{}), [&] {
      const auto& serialized_key = topic_.type().serialized_key;
      return serialized_key ? serialized_key(change) : Bytes{};
    });
    request.history.push_back(std::move(change));
    lifespan_.add({static_cast<std::int64_t>(request.history.size())}, opened.expires[i]);
  }
  return {};
}

std::shared_ptr<ChangeFilter> AnyDataWriter::filter_for(const EndpointData& reader) {
  const auto& view = topic_.type().view;
  return WriterFilter::of(reader, topic_.name(), view ? view() : nullptr);
}

void AnyDataWriter::on_time(MonotonicTime now) {
  instances_->expire_deadlines(now, [&](InstanceHandle instance) { miss_deadline(instance); });
  durability_.clean_up(context_.moment());
  lifespan_.expire(now, [&](SequenceNumber change) { protocol().discard(change); });
  call_at(next_work(now));
  context_.notify();  // discarded changes may have made room
}

MonotonicTime AnyDataWriter::next_work(MonotonicTime now) const {
  return std::min(
      {instances_->next_deadline(), lifespan_.next_tick(), durability_.next_clean_up(now)});
}

void AnyDataWriter::on_own_qos(const Qos& before) {
  durability_.set_lifespan(qos_.lifespan);
  if (!enabled()) {
    instances_.emplace(qos_);
    return;
  }
  if (qos_.deadline != before.deadline) instances_->set_deadline(qos_.deadline, context_.now());
  call_at(instances_->next_deadline());
}

// DDS 1.4, 2.2.3.21: deleting a writer unregisters its instances. Readers notice this when the
// writer disappears, but a dispose must be sent explicitly.
void AnyDataWriter::conclude() {
  const auto held = lock();
  // Stored samples outlive the writer.
  const bool outlived = qos_.durability >= DurabilityKind::transient;
  if (!enabled() || !qos_.autodispose_unregistered_instances || matched_none() || outlived) return;
  const auto moment = context_.moment();
  for (const auto& [key, octets] : instances_->keys()) {
    if (!protocol().history().has_room(octets.size(), key)) break;
    Change change;
    change.source_time = source_timestamps_.not_before_last(moment.wall);
    change.status = {.disposed = true, .unregistered = true};
    if (topic_.type().with_key) change.key_hash = key;
    change.is_key_only = true;
    change.payload = Payload::copy_of(octets);
    if (publisher().presents_)
      change.coherence = publisher().stamp(set_begin_, protocol().history().last().next());
    protocol().write(std::move(change), moment.now);
    is_concluded_ = true;
  }
  protocol().request_acknowledgments();
}

void AnyDataWriter::await_acknowledgment(std::chrono::steady_clock::time_point deadline) {
  if (!is_concluded_) return;
  auto held = lock();
  const std::chrono::nanoseconds left = deadline - std::chrono::steady_clock::now();
  context_.wait(held, std::max(left, std::chrono::nanoseconds::zero()),
                [&] { return protocol().all_acknowledged(); });
}

Result<InstanceHandle> AnyDataWriter::instance_of(const OctetWrite& change) {
  if (topic_.type().with_key && !change.key)
    return bad_parameter_error("key", "a key hash, as the type has keys", "none");
  const auto& key = change.key.value_or(KeyHash{});
  auto handle = instances_->lookup(key);
  if (!change.handle.is_nil() && change.handle != handle)
    return bad_parameter_error("handle", "the sample's instance",
                               "another, or none that is registered");
  if (handle.is_nil()) handle = instances_->enter(key, change.serialized_key);
  if (!handle.is_nil()) return handle;
  return fail(Code::rtps_out_of_resources, {.document = "writer of " + topic_.name(),
                                            .field = "RESOURCE_LIMITS.max_instances",
                                            .expected = std::to_string(instances_->size()),
                                            .found = "one more"});
}

Status AnyDataWriter::wait_for_room(std::unique_lock<std::mutex>& lock, const OctetWrite& change) {
  const auto key = change.key.value_or(KeyHash{});
  const auto timeout = qos_.reliability.max_blocking_time.to_nanoseconds();
  // A writer that is far ahead waits a little: samples that do not fit in the receiver's buffers
  // would have to be sent twice.
  const auto may_continue = [&] { return !protocol().is_ahead(context_.now()); };
  if (!may_continue()) context_.wait(lock, std::min(timeout, kBrake), may_continue);
  // Room is checked last, because other threads write while this one waits.
  const auto room = [&] { return protocol().history().has_room(change.octets().size(), key); };
  if (context_.wait(lock, timeout, room)) return {};
  return std::unexpected(
      history_full_error(protocol(), context_.protocol().remote_participants().core()));
}

Status AnyDataWriter::submit(const OctetWrite& request, StatusInfo status) {
  DDSSEC_RETURN_IF_ERROR(check_size(topic_.name(), request.octets().size()));
  auto held = lock();
  DDSSEC_RETURN_IF_ERROR(check_enabled(topic_.name()));
  DDSSEC_RETURN_IF_ERROR(
      durability_.wait_for_room(held, qos_.reliability.max_blocking_time.to_nanoseconds()));
  DDSSEC_RETURN_IF_ERROR(instance_of(request));
  DDSSEC_RETURN_IF_ERROR(wait_for_room(held, request));
  DDSSEC_RETURN_IF_ERROR(instance_of(request));  // other threads may have removed it meanwhile
  Change change;
  const auto [now, wall] = context_.moment();
  DDSSEC_ASSIGN_OR_RETURN(
      change.source_time,
      source_timestamps_.next(request.source_timestamp, wall, qos_.destination_order));
  change.status = status;
  change.key_hash = request.key;
  change.is_key_only = status != StatusInfo{};
  change.payload = request.shared.size() > 0 ? request.shared : Payload::copy_of(request.payload);
  const auto next = protocol().history().last().next();
  if (publisher().presents_) change.coherence = publisher().stamp(set_begin_, next);
  durability_.append(change, guid_, next, {now, wall});
  const auto number = protocol().write(std::move(change), now);
  after_write(request.key.value_or(KeyHash{}), status, number, now);
  context_.reschedule();
  return {};
}

void AnyDataWriter::after_write(const KeyHash& key, StatusInfo status, SequenceNumber number,
                                MonotonicTime now) {
  const bool alive = status == StatusInfo{};
  if (alive)
    instances_->note_written(key, now);
  else
    instances_->note_disposed(key);
  if (status.unregistered) instances_->remove(key);
  if (alive) lifespan_.add(number, qos_.lifespan, now);
  lifespan_.forget_dropped(protocol().history());
  call_at(next_work(now));
  liveliness_.assert_at(now, false);
}

// Ends the sequence numbers of the set. For a group, the marker must come from all writers (RTPS
// 8.7.6).
void AnyDataWriter::end_set(CoherentSetInfo marker, MonotonicTime now) {
  const bool wrote = std::exchange(set_begin_, {}).value > 0;
  if (!enabled() || (!wrote && marker.group_set.value == 0)) return;
  Change change;
  change.coherence = marker;
  protocol().write(std::move(change), now);
}

Status AnyDataWriter::write_octets(const OctetWrite& change) { return submit(change, {}); }

Result<OctetLoan> AnyDataWriter::loan_octets(std::size_t size) {
  auto loan = loan_octets_for_overwrite(size);
  if (loan) std::ranges::fill(loan->octets(), std::uint8_t{0});
  return loan;
}

Result<OctetLoan> AnyDataWriter::loan_octets_for_overwrite(std::size_t size) {
  if (size < kEncapsulationSize)
    return bad_parameter_error("size", "at least " + std::to_string(kEncapsulationSize),
                               std::to_string(size));
  DDSSEC_RETURN_IF_ERROR(check_size(topic_.name(), size));
  DDSSEC_RETURN_IF_ERROR(loans_->add(1, topic_.name()));
  LoanTicket ticket(loans_);
  return OctetLoan(Payload::uninitialized(size), std::move(ticket));
}

Status AnyDataWriter::write_octets(OctetLoan&& loan, OctetWrite change) {
  DDSSEC_RETURN_IF_ERROR(loan.check(loans_, topic_.name()));
  change.shared = loan.payload_;
  auto written = write_octets(change);
  if (written) loan = {};
  return written;
}

Status AnyDataWriter::dispose_octets(const OctetWrite& change) {
  return submit(change, {.disposed = true});
}

Status AnyDataWriter::unregister_octets(const OctetWrite& change) {
  bool disposes = false;
  {
    const auto held = lock();
    DDSSEC_RETURN_IF_ERROR(check_enabled(topic_.name()));
    if (instances_->lookup(change.key.value_or(KeyHash{})).is_nil())
      return precondition_not_met_error("writer of " + topic_.name(), "a registered instance",
                                        "another");
    disposes = qos_.autodispose_unregistered_instances;
  }
  return submit(change, {.disposed = disposes, .unregistered = true});
}

Result<InstanceHandle> AnyDataWriter::register_octets(const OctetWrite& change) {
  const auto held = lock();
  DDSSEC_RETURN_IF_ERROR(check_enabled(topic_.name()));
  return instance_of(change);
}

InstanceHandle AnyDataWriter::lookup_key(const KeyHash& key) const {
  const auto held = lock();
  return instances_->lookup(key);
}

Result<Bytes> AnyDataWriter::octets_of_key(InstanceHandle instance) const {
  const auto held = lock();
  if (const auto* key = instances_->key_value(instance)) return *key;
  return bad_parameter_error("handle", "a registered instance", "none");
}

Status AnyDataWriter::wait_for_acknowledgments(std::chrono::nanoseconds timeout) {
  auto held = lock();
  DDSSEC_RETURN_IF_ERROR(check_enabled(topic_.name()));
  protocol().request_acknowledgments();
  if (context_.wait(held, timeout, [&] { return protocol().all_acknowledged(); })) {
    held.unlock();
    return durability_.flush(timeout);
  }
  return fail(Code::rtps_timeout, {.document = "writer " + guid_.to_string()});
}

Status AnyDataWriter::assert_liveliness() {
  const auto held = lock();
  DDSSEC_RETURN_IF_ERROR(check_enabled(topic_.name()));
  liveliness_.assert_at(context_.now(), true);
  if (qos_.liveliness.kind == LivelinessKind::manual_by_topic) protocol().assert_liveliness();
  context_.reschedule();
  return {};
}

LivelinessLostStatus AnyDataWriter::liveliness_lost_status() {
  return read_status(StatusKind::liveliness_lost, liveliness_lost_);
}

void AnyDataWriter::set_listener(DataWriterListener* listener, StatusMask mask) {
  replace_listener([&] { return listeners_.set(listener, mask); });
}

}  // namespace ddssec::rtps
