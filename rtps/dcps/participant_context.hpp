// What the entities of one participant share: its lock (shared with the other participants of its
// neighbourhood), protocol, timers and callbacks.
#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>

#include "rtps/dcps/link.hpp"
#include "rtps/dcps/reader_cache.hpp"
#include "rtps/participant/participant.hpp"
#include "rtps/reliability/timer_queue.hpp"

namespace ddssec::rtps {

class Entity;

/// The lock is never held while a listener is called.
class ParticipantContext {
 public:
  /// Serves sockets and timers.
  class Server {
   public:
    virtual ~Server() = default;
    /// Ends a wait in serve(). May be called from any thread.
    virtual void wake() = 0;
    virtual void serve(std::chrono::nanoseconds most) = 0;
  };

  ParticipantContext(const Environment& environment, Server& server, bool own_thread,
                     std::shared_ptr<Neighbourhood> neighbourhood)
      : environment_(environment),
        server_(server),
        own_thread_(own_thread),
        neighbourhood_(std::move(neighbourhood)),
        mutex_(neighbourhood_->mutex()) {}

  std::mutex& mutex() const { return mutex_; }
  const std::shared_ptr<Neighbourhood>& neighbourhood() const { return neighbourhood_; }
  const Environment& environment() const { return environment_; }
  MonotonicTime now() const { return environment_.clock.monotonic(); }
  Moment moment() const { return {now(), Time::from(environment_.clock.wall())}; }

  // The caller holds the lock:
  Participant& protocol() const { return *protocol_; }
  void adopt(std::unique_ptr<Participant> protocol);
  /// From now on nothing outside calls the protocol.
  void leave();
  bool has_protocol() const { return protocol_ != nullptr; }
  TimerQueue& timers() { return timers_; }
  /// Does what is due. Returns the time of the next work, at most `most` from now.
  MonotonicTime tick(std::chrono::nanoseconds most);
  /// Returns the time of the next work, after callbacks that may have changed it.
  MonotonicTime next();
  /// Must be called after something that changes when tick() must run, or that listeners must be
  /// called for.
  void reschedule();
  /// The same after an action of another participant in the neighbourhood, which can affect only
  /// timers and listeners.
  void attend() {
    if (!serving_) wake_if(kNever);
  }
  /// Makes waiting calls check their condition again: at once, or when `serve` ends.
  void notify() {
    if (serving_)
      changed_while_serving_ = true;
    else
      changed_.notify_all();
  }
  /// Returns false if `ready` did not become true in time. A participant without a thread of its
  /// own is served meanwhile. Does not wait in a callback, because no other thread could change
  /// anything.
  template <class Ready>
  bool wait(std::unique_lock<std::mutex>& lock, std::chrono::nanoseconds most, Ready ready);
  /// The entity has a status for which its listeners must be called.
  void enqueue(Link<Entity>& entity) { entity.append_to(pending_); }

  // The caller does not hold the lock:
  /// Calls `f` with the lock held. Wakes waiting threads once, after the lock is released.
  template <class F>
  void serve(F&& f) {
    bool changed = false;
    {
      const std::lock_guard lock(mutex_);
      serving_ = true;
      f();
      serving_ = false;
      changed = std::exchange(changed_while_serving_, false);
    }
    if (changed) changed_.notify_all();
  }
  /// Calls the listeners of the enqueued entities. Returns true if there were any.
  bool dispatch();
  bool in_callback() const { return dispatching_ == this; }
  /// The callback lock. Held while listeners are called, while entities are destroyed and while
  /// listeners are replaced.
  std::recursive_mutex& callbacks() const { return callbacks_; }

 private:
  /// Wakes the server if listeners, timers or work at time `other` cannot wait, unless it has
  /// already been woken.
  void wake_if(MonotonicTime other);

  const Environment environment_;
  Server& server_;
  const bool own_thread_;
  const std::shared_ptr<Neighbourhood> neighbourhood_;
  std::mutex& mutex_;
  std::condition_variable changed_;
  bool serving_ = false;
  bool changed_while_serving_ = false;
  std::unique_ptr<Participant> protocol_;
  TimerQueue timers_;
  LinkedList<Entity> pending_;
  MonotonicTime waiting_until_ = kNever;
  bool woken_ = false;  ///< woken, but has not called tick() since
  mutable std::recursive_mutex callbacks_;
  /// The context whose listeners this thread is calling.
  static thread_local const ParticipantContext* dispatching_;
};

template <class Ready>
bool ParticipantContext::wait(std::unique_lock<std::mutex>& lock, std::chrono::nanoseconds most,
                              Ready ready) {
  constexpr std::chrono::nanoseconds kLongest = std::chrono::hours(24 * 365);
  if (ready()) return true;
  const auto end = std::chrono::steady_clock::now() + std::min(most, kLongest);
  if (in_callback()) return false;
  if (own_thread_) return changed_.wait_until(lock, end, ready);
  while (!ready()) {
    const auto left = end - std::chrono::steady_clock::now();
    if (left <= std::chrono::nanoseconds::zero()) return false;
    lock.unlock();
    server_.serve(left);
    lock.lock();
  }
  return true;
}

}  // namespace ddssec::rtps
