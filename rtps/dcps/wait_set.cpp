#include "rtps/dcps/wait_set.hpp"

#include <algorithm>

namespace ddssec::rtps {
namespace {

constexpr std::chrono::nanoseconds kLongestWait = std::chrono::hours(24 * 365);

}  // namespace

Condition::~Condition() {
  for (const auto& set : sets_) {
    const std::lock_guard lock(set->mutex);
    std::erase(set->conditions, this);
  }
}

// The value is set before the wait set's lock is taken, so that no waiter misses it.
void Condition::trigger(bool value) {
  const bool was = trigger_.exchange(value);
  if (was || !value) return;
  const std::lock_guard lock(mutex_);
  for (const auto& set : sets_) {
    { const std::lock_guard waiting(set->mutex); }
    set->changed.notify_all();
  }
}

WaitSet::WaitSet() : state_(std::make_shared<WaitSetState>()) {}

WaitSet::~WaitSet() {
  for (auto* condition : conditions()) {
    const std::lock_guard lock(condition->mutex_);
    std::erase(condition->sets_, state_);
  }
}

void WaitSet::attach_condition(Condition& condition) {
  {
    const std::lock_guard lock(condition.mutex_);
    if (std::ranges::find(condition.sets_, state_) != condition.sets_.end()) return;
    condition.sets_.push_back(state_);
  }
  const std::lock_guard lock(state_->mutex);
  state_->conditions.push_back(&condition);
  state_->changed.notify_all();
}

Status WaitSet::detach_condition(Condition& condition) {
  {
    const std::lock_guard lock(state_->mutex);
    if (std::erase(state_->conditions, &condition) == 0)
      return fail(
          Code::rtps_precondition_not_met,
          {.document = "wait set", .expected = "an attached condition", .found = "another"});
  }
  const std::lock_guard lock(condition.mutex_);
  std::erase(condition.sets_, state_);
  return {};
}

std::vector<Condition*> WaitSet::conditions() const {
  const std::lock_guard lock(state_->mutex);
  return state_->conditions;
}

Result<std::vector<Condition*>> WaitSet::wait(std::chrono::nanoseconds most) {
  std::unique_lock lock(state_->mutex);
  if (state_->waiting)
    return fail(Code::rtps_precondition_not_met,
                {.document = "wait set", .expected = "one waiting thread", .found = "a second"});
  state_->waiting = true;
  std::vector<Condition*> triggered;
  state_->changed.wait_for(lock, std::min(most, kLongestWait), [&] {
    triggered.clear();
    std::ranges::copy_if(state_->conditions, std::back_inserter(triggered),
                         &Condition::trigger_value);
    return !triggered.empty();
  });
  state_->waiting = false;
  if (triggered.empty()) return fail(Code::rtps_timeout, {.document = "wait set"});
  return triggered;
}

}  // namespace ddssec::rtps
