#include "rtps/dcps/sample_reception.hpp"

#include <algorithm>
#include <bit>

#include <fmt/format.h>

#include "rtps/dcps/count_status.hpp"
#include "rtps/participant/rtps_participant.hpp"

namespace ddssec::rtps {

SampleReception::SampleReception(const Reader& reader, Reports reports)
    : TimedObject(reader.context.timers()),
      context_(reader.context),
      topic_(reader.topic),
      filter_(reader.filter),
      keys_(reader.keys),
      reader_(reader.guid),
      reports_(std::move(reports)),
      samples_(reader.qos, reader.topic.type(), reports_.conditions.queries()) {}

void SampleReception::start(const Qos& announced, const Subscription& subscription) {
  const auto& policy = announced.presentation;
  const bool by_group = policy.scope == PresentationScope::group;
  is_exclusive_ = announced.ownership == OwnershipKind::exclusive;
  if (policy.ordered_access && policy.scope != PresentationScope::instance)
    samples_.cache().order_by_arrival(by_group ? subscription.arrivals : arrivals_);
  presentation_.start(policy, subscription.of_group, subscription.paused, context_.now());
  if (announced.durability != DurabilityKind::volatile_) samples_.expect_history();
}

void SampleReception::stop() {
  presentation_.stop(context_.now());
  cancel();
}

void SampleReception::change_qos(const Qos& before, const Qos& now, bool started) {
  if (!started) return samples_.reset(now);
  auto& cache = samples_.cache();
  if (now.deadline != before.deadline) cache.set_deadline(now.deadline, context_.now());
  cache.set_lifecycle(now.reader_data_lifecycle);
  if (now.time_based_filter != before.time_based_filter)
    cache.set_minimum_separation(now.time_based_filter);
  call_at(cache.next_tick());
}

void SampleReception::add_writer(const EndpointData& writer) {
  const auto& core = context_.protocol().remote_participants().core();
  const auto identity = core.identity_of(writer.guid.prefix);
  samples_.cache().set_writer(writer.guid, writer.qos.ownership_strength, writer.qos.lifespan,
                              identity);
  presentation_.add_writer(writer.guid, writer.group_guid, identity);
}

void SampleReception::remove_writer(const Guid& writer) {
  if (presentation_.remove_writer(writer, context_.now())) {
    // Other writers may own its instances from now on.
    if (is_exclusive_ &&
        samples_.cache().lose_writer(writer, ReaderCache::WriterLoss::not_alive, context_.now()))
      note_data();
    return;
  }
  note_left(writer);
  present_again();
}

void SampleReception::present_again() {
  presentation_.release(context_.now());
  schedule_presenter();
}

void SampleReception::note_left(const Guid& writer) {
  if (samples_.cache().lose_writer(writer, ReaderCache::WriterLoss::unmatched, context_.now()))
    note_data();
  call_at(cache().next_tick());
}

void SampleReception::lose_writers(std::span<const Guid> writers, MonotonicTime now) {
  bool changed = false;
  for (const auto& writer : writers)
    changed =
        samples_.cache().lose_writer(writer, ReaderCache::WriterLoss::not_alive, now) || changed;
  if (changed) note_data();
  present_again();
  call_at(cache().next_tick());
}

// Without coherent access or GROUP scope, changes go directly to the samples.
bool SampleReception::on_change(Change& change) {
  if (!presentation_.holds_back()) return change.is_marker() || store(change);
  const bool taken = presentation_.on_change(change, context_.now());
  if (!taken) has_refused_ = true;
  schedule_presenter();
  context_.attend();
  return taken;
}

void SampleReception::on_group(const Guid& writer, SequenceNumber group) {
  if (!presentation_.holds_back()) return;
  presentation_.on_group(writer, group, context_.now());
  context_.attend();
}

KeyHash SampleReception::instance_of(const Change& change) const {
  return samples_.instance_of(change, keys_);
}

// A filter may let few of the samples pass, so their instances do not count: only the number and
// the octets of all samples together do.
Room SampleReception::room_for(const WantedRoom& wanted, const Guid& writer) const {
  if (filter_.filter() == nullptr) return cache().room_for(wanted, writer);
  return cache().room_for({wanted.samples, wanted.octets}, writer);
}

bool SampleReception::store(Change& change) {
  using Reception = ReceivedSamples::Reception;
  const auto times_ahead = cache().times_ahead();
  const bool is_new = !change.is_examined;
  const auto received = samples_.receive(change, filter_.filter(), keys_, context_.moment());
  if (cache().times_ahead() != times_ahead) report_time_ahead(change.writer);
  call_at(cache().next_tick());
  switch (received.outcome) {
    case Reception::rejected:
      reject(change, received.stored, is_new);
      return false;
    case Reception::unreadable_key:
      report_unreadable_key(change);
      return true;
    case Reception::stored:
      note_data();
      break;
    case Reception::unseen:
      break;
  }
  context_.attend();
  return true;
}

// A reliable writer keeps the change and offers it again. The change is counted only once.
void SampleReception::reject(const Change& change, const ReaderCache::StoreReport& stored,
                             bool is_new) {
  has_refused_ = true;
  const std::pair which(change.writer, change.sequence_number);
  if (std::exchange(last_rejected_, which) == which || !is_new) return;
  add_to(rejected_);
  rejected_.last_reason = stored.reason;
  rejected_.last_instance_handle = stored.instance;
  reports_.of_reader.note(StatusKind::sample_rejected);
  if (stored.crowded) report_crowded(change.writer, stored.reason);
}

// Reports this rarely (on the 1st, 2nd, 4th, 8th ... time), because a writer that takes all places
// offers more changes than the reader can report.
void SampleReception::report_crowded(const Guid& writer, SampleRejectedReason reason) {
  const bool instances = reason == SampleRejectedReason::by_instances_limit;
  auto& count = instances ? crowded_ : crowded_samples_;
  if (!std::has_single_bit(++count)) return;
  const auto limit = instances ? std::string("RESOURCE_LIMITS.max_instances")
                               : fmt::format("{} and {} octets", HeldInstances::kMaxSamples,
                                             HeldInstances::kMaxOctets);
  context_.protocol().remote_participants().raise_about(
      Error(instances ? Code::rtps_instances_crowded : Code::rtps_samples_crowded,
            {.document = "topic " + topic_.name(),
             .field = instances ? "instances" : "samples and their octets",
             .expected = "at most " + limit + ", and of one identity no more than are free",
             .found = fmt::format("{} samples {}so far", count,
                                  instances ? "of further ones " : "more "),
             .note = "another event follows when they are twice as many"}),
      reader_.entity, writer);
}

// Reports this rarely (on the 1st, 2nd, 4th, 8th ... time), because a writer that keeps its sets
// open creates more of them than the reader can report.
void SampleReception::give_up(const Guid& writer, std::size_t samples, Limit limit) {
  on_lost(static_cast<std::int64_t>(samples));
  if (!std::has_single_bit(++given_up_)) return;
  const auto expected =
      limit == Limit::samples
          ? fmt::format(
                "at most {} samples and {} octets, all of which the "
                "reader can hold of one identity",
                cache().held().max_samples_of_one(), HeldInstances::kMaxOctetsOfOne)
          : "open sets of one identity that take no more than is free";
  context_.protocol().remote_participants().raise_about(
      Error(Code::rtps_set_given_up,
            {.document = "topic " + topic_.name(),
             .field = "coherent set",
             .expected = expected,
             .found = fmt::format("{} samples; {} sets are given up so far", samples, given_up_),
             .note = "another event follows when they are twice as many"}),
      reader_.entity, writer);
}

// Reports this rarely (on the 1st, 2nd, 4th, 8th ... time), because a clock that is wrong stays
// wrong.
void SampleReception::report_time_ahead(const Guid& writer) {
  const auto count = cache().times_ahead();
  if (!std::has_single_bit(count)) return;
  context_.protocol().remote_participants().raise_about(
      Error(Code::rtps_source_time_ahead,
            {.document = "topic " + topic_.name(),
             .field = "source timestamp",
             .expected =
                 fmt::format("at most {} s ahead of our clock", ReaderCache::kMaxAhead.count()),
             .found = fmt::format("{} samples that are further ahead so far", count),
             .note = "another event follows when they are twice as many"}),
      reader_.entity, writer);
}

void SampleReception::report_unreadable_key(const Change& change) {
  const auto octets = change.payload.view();
  context_.protocol().remote_participants().raise_about(
      Error(Code::rtps_key_unreadable,
            {.document = "topic " + topic_.name(),
             .field = change.status.disposed ? "dispose" : "unregister",
             .expected = "a key of " + topic_.type_name() + " in XCDR1 or XCDR2, or a key hash",
             .found = octets.empty()
                          ? "neither"
                          : std::to_string(octets.size()) + " octets that begin " +
                                to_hex(octets.first(std::min(octets.size(), kEncapsulationSize)))}),
      reader_.entity, change.writer);
}

// Reports this rarely (on the 1st, 2nd, 4th, 8th ... time), because a writer can send any number.
void SampleReception::report_malformed(const OctetSample& sample) {
  if (!std::has_single_bit(++discarded_)) return;
  const auto octets = sample.payload.view();
  context_.protocol().remote_participants().raise_about(
      Error(Code::rtps_sample_malformed,
            {.document = "topic " + topic_.name(),
             .field = sample.is_key_only ? "serialized key" : "serialized data",
             .expected = topic_.type_name(),
             .found = fmt::format("{} octets that begin {}; {} such samples so far", octets.size(),
                                  to_hex(octets.first(std::min<std::size_t>(octets.size(), 16))),
                                  discarded_),
             .note = "another event follows when they are twice as many"}),
      reader_.entity, sample.info.publication_handle);
}

void SampleReception::note_data() {
  update_conditions();
  reports_.of_reader.note(StatusKind::data_available);
  reports_.of_subscriber.note(StatusKind::data_on_readers);
}

void SampleReception::on_lost(std::int64_t count) {
  add_to(lost_, count);
  reports_.of_reader.note(StatusKind::sample_lost);
}

void SampleReception::on_dropped(const Guid& writer, std::uint32_t octets) {
  on_lost(1);
  context_.protocol().remote_participants().raise_about(
      Error(Code::rtps_sample_dropped,
            {.document = "topic " + topic_.name(),
             .field = "serialized size",
             .expected = fmt::format("at most {}", StatefulReader::kMaxSample),
             .found = std::to_string(octets)}),
      reader_.entity, writer);
}

// Reading resets DATA_AVAILABLE and DATA_ON_READERS (DDS 1.4, 2.2.4.2.2).
bool SampleReception::select(const SampleQuery& query, std::vector<OctetSample>& out) {
  samples_.cache().select(query, context_.moment(), out);
  reports_.of_reader.clear(StatusKind::data_available);
  reports_.of_subscriber.clear(StatusKind::data_on_readers);
  return query.take && std::exchange(has_refused_, false);
}

bool SampleReception::discard_malformed(std::span<const OctetSample> samples, bool taken) {
  if (!taken) samples_.cache().discard(samples);
  for (const auto& sample : samples) {
    samples_.count_malformed();
    report_malformed(sample);
  }
  return std::exchange(has_refused_, false);
}

void SampleReception::after_access(bool taken) {
  if (taken) present_again();
  update_conditions();
}

void SampleReception::match(QueryMatches& query) {
  query.match(cache().held().ready());
  update_conditions();
}

void SampleReception::forget_ended(std::span<const KeyHash> keys) {
  if (keys.empty()) return;
  for (const auto& key : keys) samples_.cache().forget_ended(key);
  present_again();
  update_conditions();
}

void SampleReception::pause(bool paused, MonotonicTime now) {
  presentation_.pause(paused, now);
  if (!paused) schedule_presenter();
}

void SampleReception::on_time(MonotonicTime now) {
  auto& cache = samples_.cache();
  const bool freed = cache.expire(now);
  if (freed) update_conditions();
  presentation_.release(
      now, freed ? Presenter::ReaderRoom::may_be_freed : Presenter::ReaderRoom::unchanged);
  schedule_presenter();
  if (cache.release(context_.moment())) note_data();
  cache.expire_deadlines(now, reports_.deadline_missed);
  call_at(cache.next_tick());
}

}  // namespace ddssec::rtps
