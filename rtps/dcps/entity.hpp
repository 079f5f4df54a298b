// What all entities have in common (DDS 1.4, 2.2.2.1.1).
#pragma once

#include "rtps/dcps/listener.hpp"
#include "rtps/dcps/status_changes.hpp"

namespace ddssec::rtps {

class Entity {
 public:
  virtual ~Entity();
  Entity(const Entity&) = delete;
  Entity& operator=(const Entity&) = delete;

  StatusCondition& status_condition() { return changes_.condition(); }
  /// Statuses that changed since they were last read, or a listener was told.
  StatusMask status_changes() const;
  bool is_enabled() const;
  /// Makes the entity take part; a second time does nothing. Entities are born enabled unless
  /// their container is not, or says so with autoenable_created_entities.
  /// Errors: rtps_precondition_not_met (the container is not enabled), those of the entity.
  virtual Status enable() = 0;

 protected:
  explicit Entity(ParticipantContext& context) : context_(context), changes_(*this, context) {}

  std::unique_lock<std::mutex> lock() const { return std::unique_lock(context_.mutex()); }

  // With the lock held:
  void mark_enabled() { enabled_ = true; }
  bool enabled() const { return enabled_; }
  Status check_enabled(std::string_view what) const;
  /// By default none: the entities that it contains call its listener.
  virtual bool has_listener(StatusKind) const { return false; }

  /// Calls the listeners for what changed; without the lock.
  virtual void tell_listeners() {}

  ParticipantContext& context_;
  StatusChanges changes_;

 private:
  friend class ParticipantContext;
  friend class StatusChanges;
  friend class StatusCondition;

  bool enabled_ = false;
};

/// Deleting and other calls that a listener must not make. Errors: rtps_precondition_not_met.
Status check_not_in_callback(const ParticipantContext& context);

/// What an entity may not do as things are.
inline std::unexpected<Error> precondition_not_met(std::string document, std::string expected,
                                                   std::string found) {
  return fail(Code::rtps_precondition_not_met, {.document = std::move(document),
                                                .expected = std::move(expected),
                                                .found = std::move(found)});
}

}  // namespace ddssec::rtps
