// WaitSet of DDS 1.4, 2.2.2.1.6.
#pragma once

#include <chrono>
#include <condition_variable>

#include "base/result.hpp"
#include "rtps/dcps/condition.hpp"

namespace ddssec::rtps {

/// A condition and what it shares with the wait set.
struct AttachedCondition {
  Condition* condition;
  std::shared_ptr<ConditionState> state;
};

/// What a wait set shares with the conditions attached to it.
struct WaitSetState {
  std::mutex mutex;
  std::condition_variable changed;
  /// A condition that died is not in it: only its state is used without this mutex.
  std::vector<AttachedCondition> conditions;
  bool waiting = false;
};

/// Waits until any of the attached conditions is triggered. A condition may be attached to several,
/// and while a thread waits. Participants without a thread of their own must be polled by another
/// thread meanwhile.
class WaitSet {
 public:
  WaitSet();
  ~WaitSet();
  WaitSet(const WaitSet&) = delete;
  WaitSet& operator=(const WaitSet&) = delete;

  /// Attaching twice is the same as once.
  void attach_condition(Condition& condition);
  /// Errors: rtps_precondition_not_met (it is not attached).
  Status detach_condition(Condition& condition);
  std::vector<Condition*> conditions() const;

  /// The conditions that are triggered, at least one. Whether one of them is deleted meanwhile is
  /// the application's business, as it is with conditions(). Errors: rtps_timeout,
  /// rtps_precondition_not_met (another thread waits already).
  Result<std::vector<Condition*>> wait(std::chrono::nanoseconds most);

 private:
  std::shared_ptr<WaitSetState> state_;
};

}  // namespace ddssec::rtps
