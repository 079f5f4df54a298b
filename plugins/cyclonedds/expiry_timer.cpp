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

void ExpiryTimer::run(std::stop_token stop, const Tasks& tasks) {
  while (!stop.stop_requested()) {
    try {
      tasks.revoke_ended(stop);
      const auto wait = next_wait(tasks);
      std::unique_lock lock(sleep_);
      wake_.wait_for(lock, stop, wait, [] { return false; });
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
