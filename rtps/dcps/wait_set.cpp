#include "rtps/dcps/wait_set.hpp"

#include <algorithm>

namespace ddssec::rtps {
namespace {

constexpr std::chrono::nanoseconds kLongestWait = std::chrono::hours(24 * 365);

}  // namespace

// Only trigger() holds both mutexes, and locks the condition's first. Every other function empties
// its own list before it removes itself from the lists of the others.
Condition::~Condition() {
  std::vector<std::shared_ptr<WaitSetState>> sets;
  {
    const std::lock_guard lock(state_->mutex);
    sets.swap(state_->sets);
  }
  for (const auto& set : sets) {
    const std::lock_guard lock(set->mutex);
    std::erase_if(set->conditions, [this](const auto& one) { return one.condition == this; });
  }
}

// The value is set before the wait set's mutex is locked, so that no waiting thread misses it.
void Condition::trigger(bool value) {
  const bool was = state_->trigger.exchange(value);
  if (was || !value) return;
  const std::lock_guard lock(state_->mutex);
  for (const auto& set : state_->sets) {
    { const std::lock_guard waiting(set->mutex); }
    set->changed.notify_all();
  }
}

WaitSet::WaitSet() : state_(std::make_shared<WaitSetState>()) {}

WaitSet::~WaitSet() {
  std::vector<AttachedCondition> attached;
  {
    const std::lock_guard lock(state_->mutex);
    attached.swap(state_->conditions);
  }
  for (const auto& one : attached) {
    const std::lock_guard lock(one.state->mutex);
    std::erase(one.state->sets, state_);
  }
}

void WaitSet::attach_condition(Condition& condition) {
  {
    const std::lock_guard lock(condition.state_->mutex);
    if (std::ranges::find(condition.state_->sets, state_) != condition.state_->sets.end()) return;
    condition.state_->sets.push_back(state_);
  }
  const std::lock_guard lock(state_->mutex);
  state_->conditions.push_back({&condition, condition.state_});
  state_->changed.notify_all();
}

Status WaitSet::detach_condition(Condition& condition) {
  {
    const std::lock_guard lock(state_->mutex);
    if (std::erase_if(state_->conditions,
                      [&](const auto& one) { return one.condition == &condition; }) == 0)
      return fail(
          Code::rtps_precondition_not_met,
          {.document = "wait set", .expected = "an attached condition", .found = "another"});
  }
  const std::lock_guard lock(condition.state_->mutex);
  std::erase(condition.state_->sets, state_);
  return {};
}

std::vector<Condition*> WaitSet::conditions() const {
  const std::lock_guard lock(state_->mutex);
  std::vector<Condition*> out;
  std::ranges::transform(state_->conditions, std::back_inserter(out),
                         &AttachedCondition::condition);
  return out;
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
    for (const auto& attached : state_->conditions)
      if (attached.state->trigger) triggered.push_back(attached.condition);
    return !triggered.empty();
  });
  state_->waiting = false;
  if (triggered.empty()) return fail(Code::rtps_timeout, {.document = "wait set"});
  return triggered;
}

}  // namespace ddssec::rtps
