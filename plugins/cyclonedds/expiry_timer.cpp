#include "plugins/cyclonedds/expiry_timer.hpp"

#include <algorithm>
#include <pthread.h>

#include "base/background_thread.hpp"

namespace ddssec::cyclonedds {

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

void ExpiryTimer::wake() {
  {
    const std::lock_guard lock(sleep_);
    is_woken_ = true;
  }
  wake_.notify_one();
}

void ExpiryTimer::run(std::stop_token stop, const Tasks& tasks) {
  while (!stop.stop_requested()) {
    try {
      tasks.revoke_ended(stop);
      const auto wait = next_wait(tasks);
      std::unique_lock lock(sleep_);
      wake_.wait_for(lock, stop, wait, [this] { return is_woken_; });
      is_woken_ = false;
    } catch (...) {
      // An exception would end the process; what could not be judged now is judged in a second.
      std::this_thread::sleep_for(std::min(longest_wait_, std::chrono::milliseconds(100)));
    }
  }
}

std::chrono::nanoseconds ExpiryTimer::next_wait(const Tasks& tasks) const {
  using std::chrono::milliseconds;
  std::chrono::nanoseconds wait = longest_wait_;
  if (const auto next = tasks.next_expiry()) {
    // Whole seconds: the last one may be nearly over, so look again soon rather than late.
    const milliseconds shortest(std::min<std::int64_t>(50, longest_wait_.count()));
    wait = std::clamp(milliseconds(*next - clock_.now()), shortest, longest_wait_);
  }
  if (!tasks.next_errand) return wait;
  return std::min(wait, tasks.next_errand().value_or(wait));
}

}  // namespace ddssec::cyclonedds
