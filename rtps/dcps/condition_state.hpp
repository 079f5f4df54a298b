// The states that conditions and wait sets share.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <pthread.h>
#include <utility>
#include <vector>

#include "rtps/dcps/serving_turn.hpp"

namespace ddssec::rtps {

class Condition;
struct WaitSetState;

/// The state that a condition shares with the wait sets it is attached to. It outlives both, so
/// that a condition and a wait set may be destroyed at the same time in different threads.
struct ConditionState {
  explicit ConditionState(std::shared_ptr<ServingTurn> of) : turn(std::move(of)) {}
  /// The turn of the participant whose entity triggers the condition. nullptr if the application
  /// triggers it, or if the participant has no thread of its own.
  const std::shared_ptr<ServingTurn> turn;
  std::atomic<bool> trigger = false;
  std::mutex mutex;
  std::vector<std::shared_ptr<WaitSetState>> sets;
};

/// A condition and the state that it shares with the wait set.
struct AttachedCondition {
  Condition* condition;
  std::shared_ptr<ConditionState> state;
};

/// The state that a wait set shares with the conditions attached to it.
struct WaitSetState : std::enable_shared_from_this<WaitSetState> {
  using TimePoint = std::chrono::steady_clock::time_point;

  std::mutex mutex;
  std::condition_variable changed;
  /// Never contains a destroyed condition. A thread without this mutex may only use the conditions'
  /// states.
  std::vector<AttachedCondition> conditions;
  bool is_waiting = false;
  /// The turn that the waiting thread serves; nullptr if it waits for `changed`.
  ServingTurn* served = nullptr;
  pthread_t serving{};  ///< valid if `served` is set
  /// The turns of the participants whose conditions the thread waits for. Only that thread uses
  /// them.
  std::vector<std::shared_ptr<ServingTurn>> turns;

  /// Makes the waiting thread check its conditions. The caller does not hold the mutex.
  void notify();
  /// Returns the triggered conditions. The caller holds the mutex.
  std::vector<Condition*> triggered() const;
  /// Waits until a condition is triggered or the time is over. `lock` holds the mutex.
  void wait_until(std::unique_lock<std::mutex>& lock, TimePoint end);

 private:
  /// `own` is the thread's place among those that wait for the only participant, or nullptr.
  void wait_until(std::unique_lock<std::mutex>& lock, TimePoint end, ServingTurn::WaitScope* own);
};

}  // namespace ddssec::rtps
