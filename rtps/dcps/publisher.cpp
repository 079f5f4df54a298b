#include "rtps/dcps/publisher.hpp"

#include <algorithm>

#include "rtps/dcps/domain_participant.hpp"

namespace ddssec::rtps {

Publisher::Publisher(DomainParticipant& participant, ParticipantContext& context, GroupQos qos)
    : Entity(context), participant_(participant), qos_(std::move(qos)) {}

Publisher::~Publisher() = default;

GroupQos Publisher::qos() const {
  const auto held = lock();
  return qos_;
}

Status Publisher::set_qos(const GroupQos& qos) {
  const std::lock_guard members(context_.callbacks());  // none comes or goes meanwhile
  if (is_enabled()) DDSSEC_TRY(check_mutable(this->qos(), qos));
  for (auto& writer : writers_) DDSSEC_TRY(announced_qos(writer->qos(), qos, writer->topic()));
  for (auto& writer : writers_) DDSSEC_TRY(writer->regroup(qos));
  const auto held = lock();
  qos_ = qos;
  return {};
}

Status Publisher::enable() {
  if (!participant_.is_enabled())
    return precondition_not_met("publisher", "an enabled participant", "a disabled one");
  const std::lock_guard members(context_.callbacks());
  bool all = false;
  {
    const auto held = lock();
    mark_enabled();
    all = qos_.autoenable_created_entities;
  }
  if (all)
    for (auto& writer : writers_) DDSSEC_TRY(writer->enable());
  return {};
}

void Publisher::set_listener(PublisherListener* listener, StatusMask mask) {
  const std::lock_guard callbacks(context_.callbacks());
  const auto held = lock();
  listening_ = {listener, mask};
}

Qos Publisher::default_datawriter_qos() const {
  const auto held = lock();
  return default_qos_;
}

Status Publisher::set_default_datawriter_qos(const Qos& qos) {
  DDSSEC_TRY(check_consistency(qos));
  const auto held = lock();
  default_qos_ = qos;
  return {};
}

Status Publisher::check_topic(const Topic& topic, std::string_view type) const {
  if (&topic.participant() != &participant_)
    return precondition_not_met("topic " + topic.name(), "one of the same participant",
                                "another's");
  if (topic.type_name() == type) return {};
  return fail(Code::rtps_bad_parameter, {.document = "topic " + topic.name(),
                                         .field = "type",
                                         .expected = topic.type_name(),
                                         .found = std::string(type)});
}

Status Publisher::adopt(std::unique_ptr<AnyDataWriter> writer) {
  DDSSEC_TRY(announced_qos(writer->qos(), qos(), writer->topic()));
  const std::lock_guard members(context_.callbacks());
  if (is_enabled() && qos().autoenable_created_entities) DDSSEC_TRY(writer->enable());
  const auto held = lock();
  writers_.push_back(std::move(writer));
  return {};
}

Status Publisher::delete_datawriter(AnyDataWriter& writer) {
  DDSSEC_TRY(check_not_in_callback(context_));
  const std::lock_guard members(context_.callbacks());
  std::unique_ptr<AnyDataWriter> dying;
  const auto held = lock();
  const auto at = std::ranges::find(writers_, &writer, &std::unique_ptr<AnyDataWriter>::get);
  if (at == writers_.end())
    return precondition_not_met("writer", "one of this publisher", "another's");
  dying = std::move(*at);
  writers_.erase(at);
  return {};  // the lock ends before the writer does
}

Status Publisher::delete_contained_entities() {
  DDSSEC_TRY(check_not_in_callback(context_));
  const std::lock_guard members(context_.callbacks());
  std::vector<std::unique_ptr<AnyDataWriter>> dying;
  const auto held = lock();
  dying.swap(writers_);
  return {};
}

AnyDataWriter* Publisher::lookup_datawriter(std::string_view topic_name) const {
  const auto held = lock();
  const auto at =
      std::ranges::find(writers_, topic_name, [](const auto& w) { return w->topic().name(); });
  return at == writers_.end() ? nullptr : at->get();
}

Status Publisher::wait_for_acknowledgments(std::chrono::nanoseconds most) {
  constexpr std::chrono::nanoseconds kLongest = std::chrono::hours(24 * 365);
  const auto end = std::chrono::steady_clock::now() + std::min(most, kLongest);
  std::vector<AnyDataWriter*> writers;
  {
    const auto held = lock();
    for (const auto& writer : writers_) writers.push_back(writer.get());
  }
  for (auto* writer : writers) {
    const std::chrono::nanoseconds left = end - std::chrono::steady_clock::now();
    DDSSEC_TRY(writer->wait_for_acknowledgments(std::max(left, std::chrono::nanoseconds::zero())));
  }
  return {};
}

}  // namespace ddssec::rtps
