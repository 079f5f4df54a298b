// WaitSet of DDS 1.4, 2.2.2.1.6.
#pragma once

#include <chrono>
#include <condition_variable>

#include "base/result.hpp"
#include "rtps/dcps/condition.hpp"

namespace ddssec::rtps {

/// A condition and the state that it shares with the wait set.
struct AttachedCondition {
  Condition* condition;
  std::shared_ptr<ConditionState> state;
};

/// The state that a wait set shares with the conditions attached to it.
struct WaitSetState {
  std::mutex mutex;
  std::condition_variable changed;
  /// Never contains a destroyed condition. Without this mutex only a condition's state may be used.
  std::vector<AttachedCondition> conditions;
  bool waiting = false;
};

/// Waits until any of the attached conditions is triggered. A condition may be attached to several
/// wait sets, and while a thread waits. Participants without a thread of their own must be polled
/// by another thread meanwhile. Thread-safe, but only one thread may wait.
class WaitSet {
 public:
  WaitSet();
  ~WaitSet();
  WaitSet(const WaitSet&) = delete;
  WaitSet& operator=(const WaitSet&) = delete;

  /// Attaching a condition a second time has no effect.
  void attach_condition(Condition& condition);
  /// Errors: rtps_precondition_not_met (the condition is not attached).
  Status detach_condition(Condition& condition);
  std::vector<Condition*> conditions() const;

  /// Returns the triggered conditions, at least one. The application must not use a returned
  /// pointer after it has deleted the condition; the same holds for conditions(). Errors:
  /// rtps_timeout, rtps_precondition_not_met (another thread is already waiting).
  Result<std::vector<Condition*>> wait(std::chrono::nanoseconds most);

 private:
  std::shared_ptr<WaitSetState> state_;
};

}  // namespace ddssec::rtps
