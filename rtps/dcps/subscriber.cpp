#include "rtps/dcps/subscriber.hpp"

#include <algorithm>

#include "rtps/dcps/domain_participant.hpp"

namespace ddssec::rtps {

Subscriber::Subscriber(DomainParticipant& participant, ParticipantContext& context, GroupQos qos)
    : Entity(context), participant_(participant), qos_(std::move(qos)) {}

Subscriber::~Subscriber() = default;

GroupQos Subscriber::qos() const {
  const auto held = lock();
  return qos_;
}

Status Subscriber::set_qos(const GroupQos& qos) {
  const std::lock_guard members(context_.callbacks());  // none comes or goes meanwhile
  if (is_enabled()) DDSSEC_TRY(check_mutable(this->qos(), qos));
  for (auto& reader : readers_) DDSSEC_TRY(announced_qos(reader->qos(), qos, reader->topic()));
  for (auto& reader : readers_) DDSSEC_TRY(reader->regroup(qos));
  const auto held = lock();
  qos_ = qos;
  return {};
}

Status Subscriber::enable() {
  if (!participant_.is_enabled())
    return precondition_not_met("subscriber", "an enabled participant", "a disabled one");
  const std::lock_guard members(context_.callbacks());
  bool all = false;
  {
    const auto held = lock();
    mark_enabled();
    all = qos_.autoenable_created_entities;
  }
  if (all)
    for (auto& reader : readers_) DDSSEC_TRY(reader->enable());
  return {};
}

void Subscriber::set_listener(SubscriberListener* listener, StatusMask mask) {
  const std::lock_guard callbacks(context_.callbacks());
  const auto held = lock();
  listening_ = {listener, mask};
}

SubscriberListener* Subscriber::listener_for(StatusKind kind) const {
  if (auto* own = listening_.for_status(kind)) return own;
  return participant_.listening_.for_status(kind);
}

Qos Subscriber::default_datareader_qos() const {
  const auto held = lock();
  return default_qos_;
}

Status Subscriber::set_default_datareader_qos(const Qos& qos) {
  DDSSEC_TRY(check_consistency(qos));
  const auto held = lock();
  default_qos_ = qos;
  return {};
}

Status Subscriber::check_topic(const Topic& topic, std::string_view type) const {
  if (&topic.participant() != &participant_)
    return precondition_not_met("topic " + topic.name(), "one of the same participant",
                                "another's");
  if (topic.type_name() == type) return {};
  return fail(Code::rtps_bad_parameter, {.document = "topic " + topic.name(),
                                         .field = "type",
                                         .expected = topic.type_name(),
                                         .found = std::string(type)});
}

Status Subscriber::adopt(std::unique_ptr<AnyDataReader> reader) {
  DDSSEC_TRY(announced_qos(reader->qos(), qos(), reader->topic()));
  const std::lock_guard members(context_.callbacks());
  if (is_enabled() && qos().autoenable_created_entities) DDSSEC_TRY(reader->enable());
  const auto held = lock();
  readers_.push_back(std::move(reader));
  return {};
}

Status Subscriber::delete_datareader(AnyDataReader& reader) {
  DDSSEC_TRY(check_not_in_callback(context_));
  const std::lock_guard members(context_.callbacks());
  std::unique_ptr<AnyDataReader> dying;
  const auto held = lock();
  const auto at = std::ranges::find(readers_, &reader, &std::unique_ptr<AnyDataReader>::get);
  if (at == readers_.end())
    return precondition_not_met("reader", "one of this subscriber", "another's");
  if (!reader.conditions_.empty())
    return precondition_not_met("reader", "no read conditions any more",
                                std::to_string(reader.conditions_.size()));
  dying = std::move(*at);
  readers_.erase(at);
  return {};  // the lock ends before the reader does
}

Status Subscriber::delete_contained_entities() {
  DDSSEC_TRY(check_not_in_callback(context_));
  const std::lock_guard members(context_.callbacks());
  std::vector<std::unique_ptr<AnyDataReader>> dying;
  const auto held = lock();
  dying.swap(readers_);
  return {};
}

AnyDataReader* Subscriber::lookup_datareader(std::string_view topic_name) const {
  const auto held = lock();
  const auto at =
      std::ranges::find(readers_, topic_name, [](const auto& r) { return r->topic().name(); });
  return at == readers_.end() ? nullptr : at->get();
}

std::vector<AnyDataReader*> Subscriber::datareaders(const States& states) const {
  const auto held = lock();
  std::vector<AnyDataReader*> out;
  for (const auto& reader : readers_)
    if (reader->cache_->any(states)) out.push_back(reader.get());
  return out;
}

void Subscriber::notify_datareaders() {
  const std::lock_guard members(context_.callbacks());
  for (auto* reader : datareaders({.sample = SampleState::not_read})) {
    DataReaderListener* listener = nullptr;
    {
      const auto held = lock();
      listener = reader->listener_for(StatusKind::data_available);
      if (listener != nullptr) reader->clear(StatusKind::data_available);
    }
    if (listener != nullptr) listener->on_data_available(*reader);
  }
}

}  // namespace ddssec::rtps
