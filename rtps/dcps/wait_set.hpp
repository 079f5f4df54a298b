// WaitSet of DDS 1.4, 2.2.2.1.6.
#pragma once

#include <chrono>
#include <memory>
#include <vector>

#include "base/result.hpp"
#include "rtps/dcps/condition.hpp"

namespace ddssec::rtps {

struct WaitSetState;

/// Waits until any of the attached conditions is triggered. A condition may be attached to several
/// wait sets, and while a thread waits. Participants without a thread of their own must be polled
/// by another thread meanwhile. Thread-safe, but only one thread may wait.
class WaitSet {
 public:
  WaitSet();
  ~WaitSet();
  WaitSet(const WaitSet&) = delete;
  WaitSet& operator=(const WaitSet&) = delete;

  /// Adds a condition to those that the wait set waits for. The wait set does not own it. Attaching
  /// a condition a second time has no effect.
  void attach_condition(Condition& condition);
  /// Removes the condition from those that the wait set waits for. Errors:
  /// rtps_precondition_not_met (it is not attached).
  Status detach_condition(Condition& condition);
  /// Returns the attached conditions. The wait set does not own them.
  std::vector<Condition*> conditions() const;

  /// Waits until a condition is triggered, for at most `timeout`. Returns the triggered conditions,
  /// at least one. The application must not use a returned pointer after it has deleted the
  /// condition; the same holds for conditions(). Errors: rtps_timeout, rtps_precondition_not_met
  /// (another thread is already waiting).
  Result<std::vector<Condition*>> wait(std::chrono::nanoseconds timeout);

 private:
  std::shared_ptr<WaitSetState> state_;
};

}  // namespace ddssec::rtps
