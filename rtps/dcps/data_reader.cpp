#include "rtps/dcps/data_reader.hpp"

#include <algorithm>

#include "rtps/dcps/domain_participant.hpp"
#include "rtps/dcps/subscriber.hpp"
#include "rtps/participant/rtps_participant.hpp"

namespace ddssec::rtps {
namespace {

std::unexpected<Error> no_such_instance_error() {
  return fail(Code::rtps_bad_parameter, {.document = "reader",
                                         .field = "handle",
                                         .expected = "an instance the reader knows",
                                         .found = "none"});
}

}  // namespace

AnyDataReader::AnyDataReader(Group& subscriber, ParticipantContext& context, Topic& topic, Qos qos)
    : Endpoint(subscriber, context, topic, std::move(qos),
               {"reader", "subscriber", StatusKind::subscription_matched,
                StatusKind::requested_incompatible_qos, StatusKind::requested_deadline_missed}),
      listeners_(this->subscriber().listening_, subscriber.participant().listening_),
      conditions_(*this, topic.type()),
      reception_({context, topic, qos_, keys_, filter_, guid_},
                 {changes_, this->subscriber().changes_, conditions_,
                  [this](InstanceHandle instance) { miss_deadline(instance); }}),
      liveliness_(context.timers(), *this, changes_,
                  [this](std::span<const Guid> writers, MonotonicTime now) {
                    reception_.lose_writers(writers, now);
                  }) {}

AnyDataReader::~AnyDataReader() { retire(); }

void AnyDataReader::on_retired() {
  reception_.stop();
  liveliness_.stop();
  filter_.detach();
}

Subscriber& AnyDataReader::subscriber() const { return static_cast<Subscriber&>(group_); }

Result<Guid> AnyDataReader::create(EndpointDescription request) {
  reception_.start(request.qos, {subscriber().presenter(request.qos.presentation),
                                 subscriber().arrivals_, subscriber().is_accessing()});
  request.content_filter = filter_.property();
  auto guid = context_.protocol().create_reader(std::move(request), *this, context_.now());
  if (guid) filter_.announce_for(*guid);
  return guid;
}

void AnyDataReader::on_matched(const EndpointData& remote) {
  const auto& core = context_.protocol().remote_participants().core();
  liveliness_.add_writer(remote.guid, remote.qos.liveliness.lease_duration, context_.now(),
                         core.identity_of(remote.guid.prefix));
  reception_.add_writer(remote);
  Endpoint::on_matched(remote);
}

void AnyDataReader::on_unmatched(const Guid& remote) {
  liveliness_.remove_writer(remote);
  reception_.remove_writer(remote);
  Endpoint::on_unmatched(remote);
}

void AnyDataReader::on_alive(const Guid& writer) {
  liveliness_.on_alive(writer, context_.now());
  context_.attend();
}

Status AnyDataReader::check_unused() const {
  if (conditions_.size() == 0) return {};
  return precondition_not_met_error("reader", "no read conditions any more",
                                    std::to_string(conditions_.size()));
}

Result<std::size_t> AnyDataReader::access(const SampleQuery& query, std::vector<OctetSample>& out) {
  const auto held = lock();
  DDSSEC_RETURN_IF_ERROR(check_enabled(topic_.name()));
  DDSSEC_RETURN_IF_ERROR(subscriber().check_access());
  const bool of_instance = query.scope == SampleQuery::Scope::instance;
  if (of_instance && reception_.cache().key_value(query.instance) == nullptr)
    return no_such_instance_error();
  const auto before = out.size();
  if (reception_.select(query, out)) offer_again();
  reception_.after_access(query.take);
  return out.size() - before;
}

void AnyDataReader::discard_malformed(std::span<const OctetSample> samples, bool taken) {
  const auto held = lock();
  if (reception_.discard_malformed(samples, taken)) offer_again();
  reception_.after_access(true);
}

void AnyDataReader::offer_again() {
  if (auto* reader = context_.protocol().local_endpoints().reader(guid_)) reader->offer_again();
  context_.reschedule();
}

InstanceHandle AnyDataReader::lookup_key(const KeyHash& key) const {
  const auto held = lock();
  return reception_.cache().lookup(key);
}

Result<Payload> AnyDataReader::octets_of_key(InstanceHandle instance) const {
  const auto held = lock();
  if (const auto* key = reception_.cache().key_value(instance)) return *key;
  return no_such_instance_error();
}

ReadCondition& AnyDataReader::create_readcondition(const States& states) {
  const auto held = lock();
  auto& condition = conditions_.create(states);
  reception_.update_conditions();
  return condition;
}

Result<QueryCondition*> AnyDataReader::create_querycondition(const States& states,
                                                             FilterText query) {
  const auto held = lock();
  DDSSEC_ASSIGN_OR_RETURN(auto* condition, conditions_.create(states, std::move(query)));
  if (condition->query_)
    reception_.match(*condition->query_);
  else
    reception_.update_conditions();
  return condition;
}

Status AnyDataReader::delete_readcondition(ReadCondition& condition) {
  const auto held = lock();
  return conditions_.erase(condition);
}

void AnyDataReader::delete_contained_entities() {
  const auto held = lock();
  conditions_.clear();
}

Status AnyDataReader::wait_for_historical_data(std::chrono::nanoseconds timeout) {
  auto held = lock();
  DDSSEC_RETURN_IF_ERROR(check_enabled(topic_.name()));
  if (qos_.durability == DurabilityKind::volatile_) return {};
  // A HEARTBEAT alone can complete the history and does not notify the context. The wait is
  // therefore divided into short steps.
  constexpr std::chrono::nanoseconds kStep = std::chrono::milliseconds(10);
  const auto complete = [&] {
    const auto* reader = context_.protocol().local_endpoints().reader(guid_);
    return reader == nullptr || reader->has_history();
  };
  for (auto left = timeout;; left -= kStep) {
    if (context_.wait(held, std::min(left, kStep), complete)) return {};
    if (left <= kStep || context_.in_callback()) break;
  }
  return fail(Code::rtps_timeout, {.document = "reader " + guid_.to_string()});
}

bool wait_for_samples(AnyDataReader& reader, const States& states,
                      std::chrono::nanoseconds timeout) {
  auto held = reader.lock();
  return reader.context_.wait(
      held, timeout, [&] { return reader.reception_.cache().any(states); },
      ServingTurn::WaitReason::data);
}

SampleLostStatus AnyDataReader::sample_lost_status() {
  return read_status(StatusKind::sample_lost, reception_.lost_status());
}

SampleRejectedStatus AnyDataReader::sample_rejected_status() {
  return read_status(StatusKind::sample_rejected, reception_.rejected_status());
}

LivelinessChangedStatus AnyDataReader::liveliness_changed_status() {
  const auto held = lock();
  return liveliness_.read_status();
}

void AnyDataReader::set_listener(DataReaderListener* listener, StatusMask mask) {
  replace_listener([&] { return listeners_.set(listener, mask); });
}

void AnyDataReader::notify_listeners() {
  listeners_.notify(*this, {changes_, subscriber().changes_, context_.mutex()});
}

}  // namespace ddssec::rtps
