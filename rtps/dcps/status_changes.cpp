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

}  // namespace ddssec::rtps
