#include "rtps/dcps/data_reader.hpp"

#include <algorithm>

#include "rtps/dcps/subscriber.hpp"

namespace ddssec::rtps {
namespace {

std::unexpected<Error> no_such_instance() {
  return fail(Code::rtps_bad_parameter, {.document = "reader",
                                         .field = "handle",
                                         .expected = "an instance the reader knows",
                                         .found = "none"});
}

}  // namespace

AnyDataReader::AnyDataReader(Subscriber& subscriber, ParticipantContext& context, Topic& topic,
                             Qos qos)
    : Entity(context),
      Timed(context.timers()),
      subscriber_(subscriber),
      topic_(topic),
      qos_(std::move(qos)) {
  const auto held = lock();
  ++topic_.users_;
  make_cache();
}

AnyDataReader::~AnyDataReader() {
  const auto held = lock();
  --topic_.users_;
  cancel();
  if (!enabled()) return;
  context_.protocol().remove(guid_, context_.now());
  context_.reschedule();
}

void AnyDataReader::make_cache() {
  const auto& key = topic_.type().serialized_key;
  const bool with_key = topic_.type().with_key;
  cache_.emplace(qos_, with_key && key ? ReaderCache::KeyOf(key) : nullptr);
}

Guid AnyDataReader::guid() const {
  const auto held = lock();
  return guid_;
}

Qos AnyDataReader::qos() const {
  const auto held = lock();
  return qos_;
}

Status AnyDataReader::enable() {
  if (!subscriber_.is_enabled())
    return precondition_not_met("reader", "an enabled subscriber", "a disabled one");
  auto announced = DDSSEC_TRY(announced_qos(qos(), subscriber_.qos(), topic_));
  const auto held = lock();
  if (enabled()) return {};
  guid_ = DDSSEC_TRY(context_.protocol().create_reader(
      {topic_.name(), topic_.type_name(), std::move(announced), topic_.type().with_key}, *this,
      context_.now()));
  mark_enabled();
  context_.reschedule();
  return {};
}

Status AnyDataReader::set_qos(const Qos& qos) {
  auto announced = DDSSEC_TRY(announced_qos(qos, subscriber_.qos(), topic_));
  const auto held = lock();
  if (enabled()) {
    DDSSEC_TRY(check_mutable(qos_, qos));
    DDSSEC_TRY(context_.protocol().change_qos(guid_, std::move(announced), context_.now()));
    if (qos.deadline != qos_.deadline) cache_->set_deadline(qos.deadline, context_.now());
    call_at(cache_->next_tick());
    context_.reschedule();
    qos_ = qos;
  } else {
    qos_ = qos;
    make_cache();
  }
  return {};
}

Status AnyDataReader::regroup(const GroupQos& group) {
  auto announced = DDSSEC_TRY(announced_qos(qos(), group, topic_));
  const auto held = lock();
  if (!enabled()) return {};
  DDSSEC_TRY(context_.protocol().change_qos(guid_, std::move(announced), context_.now()));
  context_.reschedule();
  return {};
}

// Reading is what resets DATA_AVAILABLE and DATA_ON_READERS (DDS 1.4, 2.2.4.2.2).
Result<std::size_t> AnyDataReader::access(const Query& query, std::vector<OctetSample>& out) {
  const auto held = lock();
  DDSSEC_TRY(check_enabled(topic_.name()));
  if (query.scope == Query::Scope::instance && cache_->key_value(query.instance) == nullptr)
    return no_such_instance();
  const auto before = out.size();
  cache_->select(query, context_.moment(), out);
  clear(StatusKind::data_available);
  subscriber_.clear(StatusKind::data_on_readers);
  if (query.take && std::exchange(refused_, false)) {
    context_.protocol().reader(guid_)->offer_again();
    context_.reschedule();
  }
  update_conditions();
  return out.size() - before;
}

InstanceHandle AnyDataReader::lookup_key(const KeyHash& key) const {
  const auto held = lock();
  return cache_->lookup(key);
}

Result<Payload> AnyDataReader::octets_of_key(InstanceHandle instance) const {
  const auto held = lock();
  if (const auto* key = cache_->key_value(instance)) return *key;
  return no_such_instance();
}

ReadCondition& AnyDataReader::create_readcondition(const States& states) {
  std::unique_ptr<ReadCondition> condition(new ReadCondition(*this, states));
  const auto held = lock();
  conditions_.push_back(std::move(condition));
  update_conditions();
  return *conditions_.back();
}

Status AnyDataReader::delete_readcondition(ReadCondition& condition) {
  const auto held = lock();
  if (std::erase_if(conditions_, [&](const auto& c) { return c.get() == &condition; }) > 0)
    return {};
  return precondition_not_met("read condition", "one of this reader", "another's");
}

void AnyDataReader::delete_contained_entities() {
  const auto held = lock();
  conditions_.clear();
}

Status AnyDataReader::check_own(const ReadCondition& condition) const {
  if (&condition.datareader() == this) return {};
  return precondition_not_met("read condition", "one of this reader", "another's");
}

void AnyDataReader::update_conditions() {
  for (auto& condition : conditions_) condition->trigger(cache_->any(condition->states()));
}

Status AnyDataReader::wait_for_historical_data(std::chrono::nanoseconds most) {
  auto held = lock();
  DDSSEC_TRY(check_enabled(topic_.name()));
  if (qos_.durability == DurabilityKind::volatile_) return {};
  // A heartbeat alone can complete it, and tells nobody.
  constexpr std::chrono::nanoseconds kStep = std::chrono::milliseconds(10);
  const auto complete = [&] { return context_.protocol().reader(guid_)->has_history(); };
  for (auto left = most;; left -= kStep) {
    if (context_.wait(held, std::min(left, kStep), complete)) return {};
    if (left <= kStep || context_.in_callback()) break;
  }
  return fail(Code::rtps_timeout, {.document = "reader " + guid_.to_string()});
}

bool AnyDataReader::wait_for_unread(std::chrono::nanoseconds most) {
  auto held = lock();
  return context_.wait(held, most, [&] { return cache_->any({.sample = SampleState::not_read}); });
}

}  // namespace ddssec::rtps
