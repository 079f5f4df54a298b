#include "rtps/dcps/entity.hpp"

namespace ddssec::rtps {

// The thread that deletes an entity holds the callback lock.
Entity::~Entity() {
  const auto held = lock();
  changes_.leave_queue();
}

StatusMask Entity::status_changes() const {
  const auto held = lock();
  return changes_.all();
}

bool Entity::is_enabled() const {
  const auto held = lock();
  return is_enabled_;
}

Status Entity::check_enabled(std::string_view what) const {
  if (is_enabled_) return {};
  return fail(Code::rtps_not_enabled, {.document = std::string(what)});
}

Status check_not_in_callback(const ParticipantContext& context) {
  if (!context.in_callback()) return {};
  return precondition_not_met_error("listener", "no deletion from within a callback", "one");
}

}  // namespace ddssec::rtps
