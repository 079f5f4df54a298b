// What the entities of one participant share: its lock (which is its neighbours' too), protocol,
// timers and callbacks.
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
  /// Who serves sockets and timers.
  class Server {
   public:
    virtual ~Server() = default;
    /// Ends a wait of serve(), from any thread.
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

  // With the lock held:
  Participant& protocol() const { return *protocol_; }
  void adopt(std::unique_ptr<Participant> protocol);
  /// It is no longer called from outside.
  void leave();
  bool has_protocol() const { return protocol_ != nullptr; }
  TimerQueue& timers() { return timers_; }
  /// Does what is due and says until when there is nothing to do, `most` from now at the latest.
  MonotonicTime tick(std::chrono::nanoseconds most);
  /// Until when there is nothing to do, after callbacks that may have changed it.
  MonotonicTime next();
  /// After something that changes when tick wants to be called, or what listeners must be told.
  void reschedule();
  /// The same after something that a neighbour did, which concerns timers and listeners only.
  void attend() {
    if (!serving_) wake_if(kNever);
  }
  /// Waiting calls look again: at once, or when `serve` is done.
  void notify() {
    if (serving_)
      changed_while_serving_ = true;
    else
      changed_.notify_all();
  }
  /// False: `ready` did not become true in time. Without a thread of its own the participant is
  /// served meanwhile; in a callback no other thread could change anything: no wait.
  template <class Ready>
  bool wait(std::unique_lock<std::mutex>& lock, std::chrono::nanoseconds most, Ready ready);
  /// Its listeners have something to hear.
  void enqueue(Link<Entity>& entity) { entity.append_to(pending_); }

  // Without the lock:
  /// Calls `f` with the lock held. Waiting threads are woken once, when the lock is free again.
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
  /// Calls the listeners of the entities that were enqueued; true if there were any.
  bool dispatch();
  bool in_callback() const { return dispatching_ == this; }
  /// Held while listeners are called, and while entities die and listeners are replaced.
  std::recursive_mutex& callbacks() const { return callbacks_; }

 private:
  /// Unless it has been woken already, if listeners, timers or `other` cannot wait.
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
  bool woken_ = false;  ///< and did not look yet
  mutable std::recursive_mutex callbacks_;
  static thread_local const ParticipantContext* dispatching_;  ///< whose listeners it calls
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
