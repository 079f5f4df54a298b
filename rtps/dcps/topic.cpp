#include "rtps/dcps/topic.hpp"

#include "rtps/dcps/count_status.hpp"
#include "rtps/dcps/domain_participant.hpp"
#include "rtps/dcps/participant_parts.hpp"

namespace ddssec::rtps {

Topic::Topic(DomainParticipant& participant, ParticipantContext& context, std::string name,
             TypeSupport type, Qos qos)
    : Entity(context),
      participant_(participant),
      name_(std::move(name)),
      type_(std::move(type)),
      qos_(std::move(qos)) {}

Topic::~Topic() = default;

Qos Topic::qos() const {
  const auto held = lock();
  return qos_;
}

Status Topic::set_qos(const Qos& qos) {
  DDSSEC_RETURN_IF_ERROR(check_consistency(qos));
  bool announced = false;
  {
    const auto held = lock();
    if (enabled()) DDSSEC_RETURN_IF_ERROR(check_mutable(qos_, qos));
    announced = qos_.topic_data != qos.topic_data;
    qos_ = qos;
  }
  if (announced) return participant_.parts_->groups.announce_again(*this);
  return {};
}

Status Topic::enable() {
  if (!participant_.is_enabled())
    return precondition_not_met_error("topic " + name_, "an enabled participant", "a disabled one");
  const auto held = lock();
  mark_enabled();
  return {};
}

void Topic::set_listener(TopicListener* listener, StatusMask mask) {
  replace_listener([&] { return listening_.set(listener, mask); });
}

TopicListener* Topic::listener_for(StatusKind kind) const {
  if (auto* own = listening_.for_status(kind)) return own;
  return participant_.listening_.for_status(kind);
}

void Topic::on_inconsistent() {
  add_to(inconsistent_);
  changes_.note(StatusKind::inconsistent_topic);
}

InconsistentTopicStatus Topic::inconsistent_topic_status() {
  const auto held = lock();
  changes_.clear(StatusKind::inconsistent_topic);
  const auto status = inconsistent_;
  inconsistent_.total_count_change = 0;
  return status;
}

void Topic::notify_listeners() {
  TopicListener* listener = nullptr;
  {
    const auto held = lock();
    if (changes_.contains(StatusKind::inconsistent_topic))
      listener = listener_for(StatusKind::inconsistent_topic);
  }
  if (listener != nullptr) listener->on_inconsistent_topic(*this, inconsistent_topic_status());
}

}  // namespace ddssec::rtps
