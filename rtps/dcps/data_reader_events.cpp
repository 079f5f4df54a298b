// AnyDataReader, the half that is called by the protocol, the timers and, for them, the listeners.
#include <algorithm>

#include "rtps/dcps/domain_participant.hpp"
#include "rtps/dcps/subscriber.hpp"

namespace ddssec::rtps {

void AnyDataReader::on_matched(const EndpointData& remote) {
  cache_->set_writer(remote.guid, remote.qos.ownership_strength, remote.qos.lifespan);
  liveliness_.add(remote.guid, remote.qos.liveliness.lease_duration, context_.now());
  liveliness_moved();
  if (presenter_ != nullptr) presenter_->add(*this, remote.guid, remote.group_guid);
  Endpoint::on_matched(remote);
}

void AnyDataReader::on_unmatched(const Guid& remote) {
  if (presenter_ != nullptr) presenter_->remove(*this, remote, context_.now());
  liveliness_.remove(remote);
  liveliness_moved();
  if (cache_->lose_writer(remote, true, context_.now())) data_came();
  call_at(cache_->next_tick());
  Endpoint::on_unmatched(remote);
}

bool AnyDataReader::on_change(Change& change) {
  if (presenter_ == nullptr) return change.is_marker() || store(change);
  const bool taken = presenter_->on_change(*this, change, context_.now());
  if (!taken) refused_ = true;
  call_at(presenter_->next_tick());
  context_.attend();
  return taken;
}

void AnyDataReader::on_group(const Guid& writer, SequenceNumber group) {
  if (presenter_ == nullptr) return;
  presenter_->on_progress(*this, writer, group, context_.now());
  context_.attend();
}

bool AnyDataReader::store(Change& change) {
  if (filter_ && change.is_alive()) {
    const auto passes = filter_->passes(change.payload.view());
    if (!passes) ++malformed_;
    if (!passes.value_or(false)) return true;
  }
  const auto& type = topic_.type();
  // What was protected is what its writer said; the hash beside it may be anybody's.
  const bool from_payload = payload_is_protected_ && change.payload.size() > 0;
  if (type.with_key && type.key_hash && (!change.key_hash || from_payload))
    change.key_hash = type.key_hash(change, key_is_protected_);
  if (type.with_key && !change.key_hash) {
    ++malformed_;
    if (!change.is_alive()) report_unreadable_key(change);
    return true;
  }
  if (seen_ && seen_->contains(change)) return true;
  // The end of an instance of which nothing passed the filter is not news.
  if (filter_ && !change.is_alive() && cache_->lookup(change.key_hash.value_or(KeyHash{})).is_nil())
    return true;
  const auto sighting = seen_ ? SeenOriginals::of(change) : SeenOriginals::Sighting{};
  const auto stored = cache_->store(change, context_.moment());
  call_at(cache_->next_tick());
  if (stored.outcome == ReaderCache::Outcome::rejected) return reject(change, stored);
  // What a reader does not see takes nobody's place.
  const bool counts = stored.outcome == ReaderCache::Outcome::stored || !sighting.claim;
  if (seen_ && counts) seen_->add(sighting);
  if (stored.outcome == ReaderCache::Outcome::stored) data_came();
  context_.attend();
  return true;
}

void AnyDataReader::report_unreadable_key(const Change& change) {
  const auto octets = change.payload.view();
  context_.environment().events.raise(Event(
      Error(Code::rtps_key_unreadable,
            {.document = "topic " + topic_.name(),
             .field = change.status.disposed ? "dispose" : "unregister",
             .expected = "a key of " + topic_.type_name() + " in XCDR1 or XCDR2, or a key hash",
             .found = octets.empty()
                          ? "neither"
                          : std::to_string(octets.size()) + " octets that begin " +
                                to_hex(octets.first(std::min(octets.size(), kEncapsulationSize)))}),
      {}, change.writer.to_string()));
}

// A reliable writer keeps it, and it is offered again; it is counted once.
bool AnyDataReader::reject(const Change& change, const ReaderCache::Stored& stored) {
  refused_ = true;
  const std::pair which(change.writer, change.sequence_number);
  if (std::exchange(last_rejected_, which) == which) return false;
  rejected_.count();
  rejected_.last_reason = stored.reason;
  rejected_.last_instance_handle = stored.instance;
  changes_.note(StatusKind::sample_rejected);
  return false;
}

void AnyDataReader::data_came() {
  update_conditions();
  changes_.note(StatusKind::data_available);
  subscriber().changes_.note(StatusKind::data_on_readers);
}

void AnyDataReader::on_sample_lost(std::int64_t count) {
  lost_.count(count);
  changes_.note(StatusKind::sample_lost);
}

void AnyDataReader::on_sample_dropped(const Guid& writer, std::uint32_t octets) {
  on_sample_lost(1);
  context_.environment().events.raise(
      Event(Error(Code::rtps_sample_dropped,
                  {.document = "topic " + topic_.name(),
                   .field = "serialized size",
                   .expected = "at most " + std::to_string(StatefulReader::kLargestSample),
                   .found = std::to_string(octets)}),
            {}, writer.to_string()));
}

// One that was dead when it was announced anew waits for the next assertion, as before.
void AnyDataReader::on_signal(const Guid& writer, std::shared_ptr<LivelinessSignal> signal) {
  if (signal && !liveliness_.is_alive(writer)) signal->notify(*this, writer);
  liveliness_.follow(writer, std::move(signal));
  liveliness_moved();
}

void AnyDataReader::on_alive(const Guid& writer) {
  liveliness_.alive(writer, context_.now());
  liveliness_moved();
  context_.attend();
}

void AnyDataReader::liveliness_moved() {
  call_at(liveliness_.next_tick());
  if (liveliness_.take_changed()) changes_.note(StatusKind::liveliness_changed);
}

void AnyDataReader::on_time(MonotonicTime now) {
  if (presenter_ != nullptr) {
    presenter_->release(now);
    call_at(presenter_->next_tick());
  }
  if (cache_->expire(now)) update_conditions();
  if (cache_->release(context_.moment())) data_came();
  cache_->check_deadlines(now, [&](InstanceHandle instance) { miss_deadline(instance); });
  bool changed = false;
  liveliness_.check(now, [&](const Guid& writer, LivelinessSignal* signal) {
    if (signal != nullptr) signal->notify(*this, writer);
    changed = cache_->lose_writer(writer, false, now) || changed;
  });
  if (changed) data_came();
  call_at(cache_->next_tick());
  liveliness_moved();
}

SampleLostStatus AnyDataReader::sample_lost_status() {
  return read_status(StatusKind::sample_lost, lost_);
}

SampleRejectedStatus AnyDataReader::sample_rejected_status() {
  return read_status(StatusKind::sample_rejected, rejected_);
}

LivelinessChangedStatus AnyDataReader::liveliness_changed_status() {
  const auto held = lock();
  changes_.clear(StatusKind::liveliness_changed);
  const auto status = liveliness_.status();
  liveliness_.reset_changes();
  return status;
}

void AnyDataReader::set_listener(DataReaderListener* listener, StatusMask mask) {
  const std::lock_guard callbacks(context_.callbacks());
  const auto held = lock();
  listening_ = {listener, mask};
}

DataReaderListener* AnyDataReader::listener_for(StatusKind kind) const {
  if (auto* own = listening_.for_status(kind)) return own;
  if (auto* group = subscriber().listening_.for_status(kind)) return group;
  return subscriber().participant().listening_.for_status(kind);
}

bool AnyDataReader::has_listener(StatusKind kind) const {
  return listener_for(kind) != nullptr ||
         (kind == StatusKind::data_available &&
          subscriber().listener_for(StatusKind::data_on_readers) != nullptr);
}

// DDS 1.4, 2.2.4.2.6: whoever listens for DATA_ON_READERS gets that instead of DATA_AVAILABLE.
void AnyDataReader::tell_of_data() {
  SubscriberListener* of_readers = nullptr;
  DataReaderListener* of_data = nullptr;
  {
    const auto held = lock();
    if (!changes_.contains(StatusKind::data_available)) return;
    of_readers = subscriber().listener_for(StatusKind::data_on_readers);
    if (of_readers == nullptr) of_data = listener_for(StatusKind::data_available);
    if (of_data != nullptr) changes_.clear(StatusKind::data_available);
    subscriber().changes_.clear(StatusKind::data_on_readers);
  }
  if (of_readers != nullptr) of_readers->on_data_on_readers(subscriber());
  if (of_data != nullptr) of_data->on_data_available(*this);
}

void AnyDataReader::tell_listeners() {
  const auto listener = [this](StatusKind kind) {
    const auto held = lock();
    return changes_.contains(kind) ? listener_for(kind) : nullptr;
  };
  if (auto* l = listener(StatusKind::subscription_matched))
    l->on_subscription_matched(*this, subscription_matched_status());
  if (auto* l = listener(StatusKind::requested_incompatible_qos))
    l->on_requested_incompatible_qos(*this, requested_incompatible_qos_status());
  if (auto* l = listener(StatusKind::liveliness_changed))
    l->on_liveliness_changed(*this, liveliness_changed_status());
  if (auto* l = listener(StatusKind::requested_deadline_missed))
    l->on_requested_deadline_missed(*this, requested_deadline_missed_status());
  if (auto* l = listener(StatusKind::sample_lost)) l->on_sample_lost(*this, sample_lost_status());
  if (auto* l = listener(StatusKind::sample_rejected))
    l->on_sample_rejected(*this, sample_rejected_status());
  tell_of_data();
}

}  // namespace ddssec::rtps
