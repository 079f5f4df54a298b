#include "rtps/dcps/status_changes.hpp"

#include "rtps/dcps/entity.hpp"

namespace ddssec::rtps {

void StatusChanges::note(StatusKind kind) {
  changed_ = changed_ | kind;
  condition_.update();
  if (entity_.has_listener(kind)) context_.enqueue(pending_);
  context_.notify();
}

void StatusChanges::clear(StatusKind kind) {
  changed_ = changed_.without(kind);
  condition_.update();
}

void StatusCondition::update() {
  trigger(!(entity_.changes_.all() & StatusMask::from(enabled_)).empty());
}

void StatusCondition::set_enabled_statuses(StatusMask statuses) {
  const auto held = entity_.lock();
  enabled_ = statuses.bits;
  update();
}

}  // namespace ddssec::rtps
