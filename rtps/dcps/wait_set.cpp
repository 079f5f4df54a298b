#include "rtps/dcps/wait_set.hpp"

#include <algorithm>
#include <list>

#include "base/rollback.hpp"
#include "rtps/dcps/condition_state.hpp"

namespace ddssec::rtps {
namespace {

constexpr std::chrono::nanoseconds kMaxWait = std::chrono::hours(24 * 365);

}  // namespace

// A thread that serves is not woken for what it triggers itself: it checks the conditions
// afterwards.
void WaitSetState::notify() {
  const std::lock_guard held(mutex);
  changed.notify_all();
  if (served != nullptr && ::pthread_equal(serving, ::pthread_self()) == 0) served->wake();
}

std::vector<Condition*> WaitSetState::triggered() const {
  std::vector<Condition*> out;
  for (const auto& attached : conditions)
    if (attached.state->trigger) out.push_back(attached.condition);
  return out;
}

// Each participant of the conditions must know that a thread waits. If there is only one, the
// thread serves it. If that participant is deleted meanwhile, its turn is closed but still exists.
void WaitSetState::wait_until(std::unique_lock<std::mutex>& lock, TimePoint end) {
  turns.clear();
  for (const auto& attached : conditions)
    if (attached.state->turn && std::ranges::find(turns, attached.state->turn) == turns.end())
      turns.push_back(attached.state->turn);
  if (turns.size() == 1) {
    ServingTurn::WaitScope place(*turns.front(), ServingTurn::WaitReason::data, shared_from_this());
    return wait_until(lock, end, &place);
  }
  std::list<ServingTurn::WaitScope> places;
  for (const auto& turn : turns)
    places.emplace_back(*turn, ServingTurn::WaitReason::other, shared_from_this());
  wait_until(lock, end, nullptr);
}

void WaitSetState::wait_until(std::unique_lock<std::mutex>& lock, TimePoint end,
                              ServingTurn::WaitScope* own) {
  const auto any = [](const auto& attached) { return attached.state->trigger.load(); };
  while (std::ranges::none_of(conditions, any)) {
    const auto left = end - std::chrono::steady_clock::now();
    if (left <= std::chrono::nanoseconds::zero()) return;
    if (own == nullptr || !own->serves()) {
      changed.wait_until(lock, end);
      continue;
    }
    served = turns.front().get();
    serving = ::pthread_self();
    lock.unlock();
    const Rollback is_served([&] {
      lock.lock();
      served = nullptr;
    });
    own->serve(left);
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
  {
    const std::lock_guard lock(state_->mutex);
    state_->conditions.push_back({&condition, condition.state_});
  }
  state_->notify();
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

Result<std::vector<Condition*>> WaitSet::wait(std::chrono::nanoseconds timeout) {
  const auto end = std::chrono::steady_clock::now() + std::min(timeout, kMaxWait);
  std::unique_lock lock(state_->mutex);
  if (state_->is_waiting)
    return fail(Code::rtps_precondition_not_met,
                {.document = "wait set", .expected = "one waiting thread", .found = "a second"});
  state_->is_waiting = true;
  // This also happens if the thread is cancelled.
  const Rollback is_over([&] { state_->is_waiting = false; });
  auto out = state_->triggered();
  if (out.empty()) {
    state_->wait_until(lock, end);
    out = state_->triggered();
  }
  if (out.empty()) return fail(Code::rtps_timeout, {.document = "wait set"});
  return out;
}

}  // namespace ddssec::rtps
