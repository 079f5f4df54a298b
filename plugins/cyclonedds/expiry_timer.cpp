#include "plugins/cyclonedds/expiry_timer.hpp"

#include <algorithm>
#include <pthread.h>
#include <set>

#include "base/background_thread.hpp"

namespace ddssec::cyclonedds {
namespace {

struct Timers {
  std::mutex mutex;
  std::set<ExpiryTimer*> all;
};

// Never destroyed, because a thread of the host may ask while the process exits.
Timers& timers() {
  static auto& out = *new Timers;
  return out;
}

}  // namespace

ExpiryTimer::ExpiryTimer(const Clock& clock, std::chrono::milliseconds longest_wait)
    : clock_(clock), longest_wait_(longest_wait) {
  const std::lock_guard lock(timers().mutex);
  timers().all.insert(this);
}

ExpiryTimer::~ExpiryTimer() {
  stop();
  const std::lock_guard lock(timers().mutex);
  timers().all.erase(this);
}

void ExpiryTimer::wake_all() noexcept {
  const std::lock_guard lock(timers().mutex);
  for (auto* const timer : timers().all) {
    const std::lock_guard sleeping(timer->sleep_);
    timer->is_due_ = true;
    timer->wake_.notify_all();
  }
}

void ExpiryTimer::start(Tasks tasks) {
  stop();
  const std::lock_guard lock(control_);
  thread_ = start_background_thread<std::jthread>(
      [this, tasks = std::move(tasks)](std::stop_token stop) { run(std::move(stop), tasks); });
  pthread_setname_np(thread_.native_handle(), "ddssec.expiry");
}

void ExpiryTimer::stop() {
  const std::lock_guard lock(control_);
  thread_.request_stop();
  if (thread_.joinable() && thread_.get_id() != std::this_thread::get_id()) thread_.join();
}

void ExpiryTimer::run(std::stop_token stop, const Tasks& tasks) {
  while (!stop.stop_requested()) {
    try {
      tasks.revoke_ended(stop);
      const auto wait = next_wait(tasks);
      const auto pause = std::min(wait, kMinPause);
      std::unique_lock lock(sleep_);
      wake_.wait_for(lock, stop, pause, [] { return false; });
      wake_.wait_for(lock, stop, wait - pause, [this] { return is_due_; });
      is_due_ = false;
    } catch (...) {
      // An exception would end the process. Whatever could not be checked is checked again soon.
      std::this_thread::sleep_for(std::min(longest_wait_, std::chrono::milliseconds(100)));
    }
  }
}

std::chrono::milliseconds ExpiryTimer::next_wait(const Tasks& tasks) const {
  const auto next = tasks.next_expiry();
  if (!next) return longest_wait_;
  const std::chrono::milliseconds left = *next - clock_.calendar_seconds();
  // The clock has whole seconds, and the last one may be nearly over, so the check comes rather too
  // early than too late.
  return std::clamp(left,
                    std::chrono::milliseconds(std::min<std::int64_t>(50, longest_wait_.count())),
                    longest_wait_);
}

}  // namespace ddssec::cyclonedds
