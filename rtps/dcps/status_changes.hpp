// The communication statuses of an entity that have changed (DDS 1.4, 2.2.2.1.1.4).
#pragma once

#include "rtps/dcps/condition.hpp"
#include "rtps/dcps/participant_context.hpp"

namespace ddssec::rtps {

/// The statuses that changed since the application read them or a listener was called for them.
/// They trigger the entity's StatusCondition. The caller holds the participant's lock.
class StatusChanges {
 public:
  /// `entity` and `context` must outlive this object.
  StatusChanges(Entity& entity, ParticipantContext& context)
      : entity_(entity), context_(context), condition_(entity, context.turn()), pending_(&entity) {}

  /// Notes that the status changed. Waiting calls check their condition again, and the status's
  /// listener, if there is one, will be called.
  void note(StatusKind kind);
  /// Notes that the status was read.
  void clear(StatusKind kind);
  bool contains(StatusKind kind) const { return changed_.contains(kind); }
  StatusMask all() const { return changed_; }
  /// Removes the entity from the queue of entities whose listeners must be called.
  void leave_queue() { pending_.leave(); }

  StatusCondition& condition() { return condition_; }

 private:
  Entity& entity_;
  ParticipantContext& context_;
  StatusCondition condition_;
  Link<Entity> pending_;
  StatusMask changed_;
};

}  // namespace ddssec::rtps
