#include "rtps/dcps/callback_lock.hpp"

#include <condition_variable>
#include <mutex>
#include <utility>

namespace ddssec::rtps {

struct CallbackLock::Waiter {
  const ThreadId thread;
  const CallbackLock& lock;
  const bool is_first;
  Waiter* next = nullptr;
};

// All waits of the process. The list is in the stacks of the waiting threads, so that a wait
// allocates nothing.
struct CallbackLock::WaitList {
  std::mutex mutex;  // protects the list and all locks
  std::condition_variable changed;
  Waiter* list = nullptr;
  std::size_t count = 0;

  void add(Waiter& one) {
    one.next = std::exchange(list, &one);
    ++count;
    changed.notify_all();  // because of this wait, waits of other threads may never end
  }
  void remove(const Waiter& one) {
    auto** at = &list;
    while (*at != &one) at = &(*at)->next;
    *at = one.next;
    --count;
  }
};

CallbackLock::WaitList& CallbackLock::waits() {
  static WaitList all;
  return all;
}

// The waits must be destroyed after the last lock.
CallbackLock::CallbackLock() { waits(); }

const CallbackLock::Waiter* CallbackLock::waiting(ThreadId thread) {
  for (const auto* one = waits().list; one != nullptr; one = one->next)
    if (one->thread == thread) return one;
  return nullptr;
}

// Follows the chain: the thread that holds the lock, the lock for which that thread waits, the
// thread that holds that one, and so on. A chain cannot have more steps than there are waits,
// unless it leads into a circle of other threads, which they resolve.
bool CallbackLock::never_ends(const Waiter& own) const {
  const auto* lock = this;
  for (std::size_t steps = 0; steps <= waits().count && lock->depth_ > 0; ++steps) {
    if (lock->owner_ == own.thread) return true;
    const auto* other = waiting(lock->owner_);
    if (other == nullptr || (own.is_first && !other->is_first)) return false;
    lock = &other->lock;
  }
  return false;
}

bool CallbackLock::wait_for(Waiter& own) {
  auto& all = waits();
  std::unique_lock held(all.mutex, std::adopt_lock);
  all.add(own);
  while (depth_ > 0 && !never_ends(own)) all.changed.wait(held);
  all.remove(own);
  held.release();
  return depth_ == 0;
}

void CallbackLock::take(ThreadId thread) {
  owner_ = thread;
  ++depth_;
}

bool CallbackLock::acquire(Wait wait) {
  thread_local const char self_object = 0;
  const ThreadId self = &self_object;
  const std::lock_guard held(waits().mutex);
  const bool is_free = depth_ == 0 || owner_ == self;
  Waiter own{self, *this, wait == Wait::first};
  if (!is_free && (wait == Wait::none || !wait_for(own))) return false;
  take(self);
  return true;
}

void CallbackLock::release() {
  auto& all = waits();
  const std::lock_guard held(all.mutex);
  if (--depth_ == 0 && all.list != nullptr) all.changed.notify_all();
}

}  // namespace ddssec::rtps
