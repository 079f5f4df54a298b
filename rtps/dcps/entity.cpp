#include "rtps/dcps/entity.hpp"

namespace ddssec::rtps {

// Whoever deletes an entity holds the lock of callbacks.
Entity::~Entity() {
  const auto held = lock();
  pending_.leave();
}

StatusMask Entity::status_changes() const {
  const auto held = lock();
  return changes_;
}

bool Entity::is_enabled() const {
  const auto held = lock();
  return enabled_;
}

Status Entity::check_enabled(std::string_view what) const {
  if (enabled_) return {};
  return fail(Code::rtps_not_enabled, {.document = std::string(what)});
}

void Entity::note(StatusKind kind) {
  changes_ = changes_ | kind;
  condition_.update();
  if (has_listener(kind)) context_.enqueue(pending_);
  context_.notify();
}

void Entity::clear(StatusKind kind) {
  changes_ = changes_.without(kind);
  condition_.update();
}

void StatusCondition::update() {
  trigger(!(entity_.changes_ & StatusMask::from(enabled_)).empty());
}

void StatusCondition::set_enabled_statuses(StatusMask statuses) {
  const auto held = entity_.lock();
  enabled_ = statuses.bits;
  update();
}

Status check_not_in_callback(const ParticipantContext& context) {
  if (!context.in_callback()) return {};
  return precondition_not_met("listener", "no deletion from within a callback", "one");
}

}  // namespace ddssec::rtps
