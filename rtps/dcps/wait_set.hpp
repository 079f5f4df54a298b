// WaitSet of DDS 1.4, 2.2.2.1.6.
#pragma once

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <pthread.h>
#include <vector>

#include "base/result.hpp"
#include "rtps/dcps/condition.hpp"
#include "rtps/dcps/serving_turn.hpp"

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
  /// What the waiting thread serves; nullptr: it waits for `changed`.
  ServingTurn* served = nullptr;
  pthread_t serving{};  ///< valid if `served` is set
  /// Those of the participants whose conditions the thread waits for; for that thread alone.
  std::vector<std::shared_ptr<ServingTurn>> turns;

  /// Makes the waiting thread check its conditions. The caller does not hold the mutex.
  void notify();
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

  /// From now on the wait set waits for the condition too, which it does not own. Attaching a
  /// condition a second time has no effect.
  void attach_condition(Condition& condition);
  /// From now on the wait set does not wait for the condition. Errors: rtps_precondition_not_met
  /// (it is not attached).
  Status detach_condition(Condition& condition);
  /// The attached conditions. They belong to their owners.
  std::vector<Condition*> conditions() const;

  /// Waits until a condition is triggered, for at most `timeout`. Returns the triggered conditions,
  /// at least one. The application must not use a returned pointer after it has deleted the
  /// condition; the same holds for conditions(). Errors: rtps_timeout, rtps_precondition_not_met
  /// (another thread is already waiting).
  Result<std::vector<Condition*>> wait(std::chrono::nanoseconds timeout);

 private:
  std::vector<Condition*> triggered() const;
  void wait_until(std::unique_lock<std::mutex>& lock, std::chrono::steady_clock::time_point end);
  void wait_until(std::unique_lock<std::mutex>& lock, std::chrono::steady_clock::time_point end,
                  ServingTurn::Waiting* own);
  std::shared_ptr<WaitSetState> state_;
};

}  // namespace ddssec::rtps
