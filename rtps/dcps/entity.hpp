// The common base class of all entities (DDS 1.4, 2.2.2.1.1).
#pragma once

#include <mutex>
#include <string>
#include <string_view>
#include <utility>

#include "rtps/dcps/listener.hpp"
#include "rtps/dcps/status_changes.hpp"

namespace ddssec::rtps {

/// An entity of DDS. Thread-safe, as are all derived classes unless they say otherwise.
/// Applications do not derive from it.
class Entity {
 public:
  virtual ~Entity();
  Entity(const Entity&) = delete;
  Entity& operator=(const Entity&) = delete;

  /// Returns the condition for a WaitSet, owned by the entity.
  StatusCondition& status_condition() { return changes_.condition(); }
  /// Returns the statuses that changed since the application read them or a listener was called for
  /// them.
  StatusMask status_changes() const;
  /// True after enable().
  bool is_enabled() const;
  /// Enables the entity, so that it takes part in communication. Has no effect on an enabled
  /// entity. Entities are created enabled, unless their container is not enabled or has
  /// autoenable_created_entities set to false.
  /// Errors: rtps_precondition_not_met (the container is not enabled), those of the entity.
  virtual Status enable() = 0;

 protected:
  explicit Entity(ParticipantContext& context) : context_(context), changes_(*this, context) {}

  std::unique_lock<std::mutex> lock() const { return std::unique_lock(context_.mutex()); }

  // The caller holds the lock:
  void mark_enabled() { is_enabled_ = true; }
  bool enabled() const { return is_enabled_; }
  Status check_enabled(std::string_view what) const;
  /// True if a listener handles this status of the entity. False by default: the listener of a
  /// group or a participant is called for the entities that it contains.
  virtual bool has_listener(StatusKind) const { return false; }

  /// Calls the listeners for the statuses that changed. The caller does not hold the lock.
  virtual void notify_listeners() {}

  /// Calls `replace` with the lock held. It sets a listener and returns true if there was one
  /// before. Then waits until no other thread is calling the former one. The caller does not hold
  /// the lock.
  template <class Replace>
  void replace_listener(Replace replace) {
    bool had_one = false;
    {
      const auto held = lock();
      had_one = replace();
    }
    if (had_one) context_.await_callbacks();
  }

  ParticipantContext& context_;
  StatusChanges changes_;

 private:
  friend class ParticipantContext;
  friend class StatusChanges;
  friend class StatusCondition;

  bool is_enabled_ = false;
};

/// Refuses deletions and other calls that a listener must not make. Errors:
/// rtps_precondition_not_met.
Status check_not_in_callback(const ParticipantContext& context);

/// Returns the error for a call that is not allowed in the entity's current state.
inline std::unexpected<Error> precondition_not_met_error(std::string document, std::string expected,
                                                         std::string found) {
  return fail(Code::rtps_precondition_not_met, {.document = std::move(document),
                                                .expected = std::move(expected),
                                                .found = std::move(found)});
}

}  // namespace ddssec::rtps
