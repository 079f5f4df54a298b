// The objects that the entities of one participant share: its lock (shared with the other
// participants of its process peers), protocol, timers and callbacks.
#pragma once

#include <algorithm>
#include <condition_variable>
#include <mutex>

#include "base/plugin_services.hpp"
#include "rtps/dcps/callback_lock.hpp"
#include "rtps/dcps/link.hpp"
#include "rtps/dcps/reader_cache.hpp"
#include "rtps/dcps/serving_turn.hpp"
#include "rtps/participant/process_peers.hpp"
#include "rtps/reliability/timer_queue.hpp"

namespace ddssec::rtps {

class Entity;
class RtpsParticipant;

/// The lock is never held while a listener is called. Locks are taken in this order: the callback
/// lock, the lock of members, the lock.
class ParticipantContext {
 public:
  /// Serves sockets and timers.
  class Server {
   public:
    virtual ~Server() = default;
    /// Ends a wait in serve(). May be called from any thread.
    virtual void wake() = 0;
    virtual void serve(std::chrono::nanoseconds timeout) = 0;
  };

  /// `turn` is nullptr if the participant has no thread of its own.
  ParticipantContext(const PluginServices& services, Server& server,
                     std::shared_ptr<ServingTurn> turn,
                     std::shared_ptr<ProcessPeers> process_peers);
  ~ParticipantContext();

  std::mutex& mutex() const { return mutex_; }
  const std::shared_ptr<ServingTurn>& turn() const { return turn_; }
  const std::shared_ptr<ProcessPeers>& process_peers() const { return process_peers_; }
  const PluginServices& services() const { return services_; }
  MonotonicTime now() const { return services_.clock.monotonic(); }
  Moment moment() const { return {now(), Time::from(services_.clock.calendar_nanoseconds())}; }

  // The caller holds the lock:
  RtpsParticipant& protocol() const { return *protocol_; }
  const GuidPrefix& prefix() const;  ///< prefix of the protocol
  void adopt(std::unique_ptr<RtpsParticipant> protocol);
  /// Leaves the process peers. After that, nothing outside this object calls the protocol.
  void leave();
  bool has_protocol() const { return protocol_ != nullptr; }
  TimerQueue& timers() { return timers_; }
  /// Does what is due. Returns the time of the next work, at most `timeout` from now.
  MonotonicTime tick(std::chrono::nanoseconds timeout);
  /// Returns the time of the next work, after callbacks that may have changed it.
  MonotonicTime next();
  /// Call it after a change because of which tick() must run at another time, or listeners
  /// must be called.
  void reschedule();
  /// As reschedule, after an action of another participant of this process, which can affect only
  /// timers and listeners.
  void attend() {
    if (!is_serving_) wake_if(kNever);
  }
  /// Makes waiting calls check their condition again: at once, or when `serve` ends.
  void notify() {
    if (is_serving_)
      has_changed_while_serving_ = true;
    else
      notify_now();
  }
  /// Returns false if `ready` did not become true in time. A participant without a thread of its
  /// own is served meanwhile. Does not wait in a callback, because no other thread could change
  /// anything. A thread that waits for data may serve a participant that has a thread.
  template <class Ready>
  bool wait(std::unique_lock<std::mutex>& lock, std::chrono::nanoseconds timeout, Ready ready,
            ServingTurn::WaitReason reason = ServingTurn::WaitReason::other);
  bool has_pending() const { return !pending_.empty(); }
  /// Notes that listeners must be called for a status of the entity.
  void enqueue(Link<Entity>& entity) { entity.append_to(pending_); }

  // The caller does not hold the lock:
  /// Calls `f` with the lock held. Wakes waiting threads once, after the lock is released.
  template <class F>
  void serve(F&& f) {
    bool changed = false;
    {
      const std::lock_guard lock(mutex_);
      const ServingScope serving(*this, changed);
      f();
    }
    if (changed) changed_.notify_all();
  }
  /// Calls the listeners of the enqueued entities. Returns true if there were any. While another
  /// thread deletes entities it does nothing: that thread wakes the server afterwards.
  bool dispatch();
  /// Makes waiting calls check their condition again, or serve.
  void notify_waiting() {
    const std::lock_guard lock(mutex_);
    notify_now();
  }
  /// True if this thread is calling a listener of the participant.
  bool in_callback() const;
  /// Exists in the thread that calls listeners, from before the first call until after the last
  /// one.
  class CallingScope {
   public:
    CallingScope(const ParticipantContext& context, CallbackLock::Wait wait);
    ~CallingScope();
    CallingScope(const CallingScope&) = delete;
    CallingScope& operator=(const CallingScope&) = delete;
    /// False if no listener may be called now.
    explicit operator bool() const { return holds_; }

   private:
    friend class ParticipantContext;
    const ParticipantContext& context_;
    const bool holds_;
    const CallingScope* const outer_;
  };
  /// See NoCallbacks, which calls both.
  [[nodiscard]] bool hold_callbacks(CallbackLock::Wait wait) { return callbacks_.acquire(wait); }
  void resume_callbacks();
  /// Waits until the listeners that other threads are calling have returned, unless they wait for
  /// the caller.
  void await_callbacks() {
    if (hold_callbacks(CallbackLock::Wait::while_it_ends)) resume_callbacks();
  }
  /// Returns the lock of members. While it is held, no entity is added or removed. It is never held
  /// while a listener is called, so that listeners of all participants may create entities.
  std::recursive_mutex& members() const { return members_; }

 private:
  /// Exists while work is done with the lock held, also if an exception ends the work.
  struct ServingScope {
    ServingScope(ParticipantContext& of, bool& has_changed) : context(of), changed(has_changed) {
      context.is_serving_ = true;
    }
    ~ServingScope() {
      context.is_serving_ = false;
      changed = std::exchange(context.has_changed_while_serving_, false);
    }
    ParticipantContext& context;
    bool& changed;
  };
  void notify_now() {
    changed_.notify_all();
    if (std::exchange(is_served_by_waiting_, false)) turn_->wake();
  }
  template <class Ready>
  bool wait_beside_thread(std::unique_lock<std::mutex>& lock,
                          std::chrono::steady_clock::time_point end, Ready ready,
                          ServingTurn::WaitReason reason);
  /// Wakes the server for listeners, timers or work at time `other` that cannot wait, unless it has
  /// already been woken.
  void wake_if(MonotonicTime other);

  const PluginServices services_;
  Server& server_;
  const std::shared_ptr<ServingTurn> turn_;
  const std::shared_ptr<ProcessPeers> process_peers_;
  std::mutex& mutex_;
  std::condition_variable changed_;
  bool is_served_by_waiting_ = false;  ///< a waiting thread serves here, and must be woken
  bool is_serving_ = false;
  bool has_changed_while_serving_ = false;
  std::unique_ptr<RtpsParticipant> protocol_;
  TimerQueue timers_;
  LinkedList<Entity> pending_;
  MonotonicTime waiting_until_ = kNever;
  bool is_woken_ = false;  ///< woken, but has not called tick() since
  mutable CallbackLock callbacks_;
  mutable std::recursive_mutex members_;
  /// The listener call of this thread: the innermost one if a listener calls poll().
  static thread_local const CallingScope* calling_;
};

template <class Ready>
bool ParticipantContext::wait(std::unique_lock<std::mutex>& lock, std::chrono::nanoseconds timeout,
                              Ready ready, ServingTurn::WaitReason reason) {
  constexpr std::chrono::nanoseconds kMax = std::chrono::hours(24 * 365);
  if (ready()) return true;
  const auto end = std::chrono::steady_clock::now() + std::min(timeout, kMax);
  if (in_callback()) return false;
  if (turn_ != nullptr) return wait_beside_thread(lock, end, ready, reason);
  while (!ready()) {
    const auto left = end - std::chrono::steady_clock::now();
    if (left <= std::chrono::nanoseconds::zero()) return false;
    lock.unlock();
    server_.serve(left);
    lock.lock();
  }
  return true;
}

template <class Ready>
bool ParticipantContext::wait_beside_thread(std::unique_lock<std::mutex>& lock,
                                            std::chrono::steady_clock::time_point end, Ready ready,
                                            ServingTurn::WaitReason reason) {
  ServingTurn::WaitScope waiting(*turn_, reason);
  while (!ready()) {
    const auto left = end - std::chrono::steady_clock::now();
    if (left <= std::chrono::nanoseconds::zero()) return false;
    if (!waiting.serves()) {
      changed_.wait_until(lock, end);
      continue;
    }
    is_served_by_waiting_ = true;
    lock.unlock();
    waiting.serve(left);
    lock.lock();
    is_served_by_waiting_ = false;
  }
  return true;
}

}  // namespace ddssec::rtps
