// Decides which thread serves the sockets and timers of a participant: its own, or the application
// thread that waits for data ("leader and followers"). A thread that waits and serves gets its data
// without a further switch of threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>

#include "base/clock.hpp"
#include "base/file_descriptor.hpp"

namespace ddssec::rtps {

struct WaitSetState;

/// There is one for each participant with a thread of its own, shared with objects that may outlive
/// the participant.
///
/// The participant's thread has the turn at first. It gives the turn to a thread that waits for
/// data if no other thread waits, and if that thread came back soon after its last wait. The thread
/// that serves gives the turn up when its wait ends. If none takes it within kGrace, the
/// participant's thread does: a timer wakes it, so that a wait that ends wakes no thread.
///
/// A thread of the application may be held up by a long signal handler or a low priority. If it
/// does not return from its wait for kHeld, the participant's thread takes the turn away. It cannot
/// do so while the thread is held up in the middle of its work.
///
/// Only the participant's thread calls listeners. So a thread that waits may hold locks that
/// listeners take. Thread-safe.
class ServingTurn {
 public:
  using Clock = std::chrono::steady_clock;
  /// How long sockets and timers may wait after a wait has ended.
  static constexpr std::chrono::nanoseconds kGrace = std::chrono::milliseconds(1);
  /// How long the participant's thread keeps the turn after work that a waiting thread cannot do
  /// well: data in bulk, listeners, and waits of several threads.
  static constexpr std::chrono::nanoseconds kAfterBulk = std::chrono::milliseconds(10);
  static constexpr std::chrono::nanoseconds kAfterListeners = std::chrono::milliseconds(100);
  /// A thread that serves returns after this time, even if there is nothing to do. The
  /// participant's thread checks as often.
  static constexpr std::chrono::nanoseconds kMaxServe = std::chrono::milliseconds(100);
  /// After this time without progress, a thread that serves counts as held up.
  static constexpr std::chrono::nanoseconds kHeld = std::chrono::milliseconds(300);
  /// How long the participant's thread keeps the turn after it took it from a thread held up.
  static constexpr std::chrono::nanoseconds kAfterHeld = std::chrono::seconds(1);
  /// The longest sleep of the participant's thread.
  static constexpr std::chrono::nanoseconds kMaxOwn = std::chrono::seconds(10);
  /// The same, while a thread from which it took the turn may still wait for the same sockets.
  static constexpr std::chrono::nanoseconds kBesideHeld = std::chrono::milliseconds(10);

  class WaitScope;
  class Server {
   public:
    virtual ~Server() = default;
    /// Waits for sockets and timers once, for at most `timeout`, and serves them. All work is done
    /// between `waiting.begin_work()`, if that returns true, and `waiting.end_work()`. Calls no
    /// listener.
    virtual void serve_for_waiting(std::chrono::nanoseconds timeout, WaitScope& waiting) = 0;
    /// Ends a call of serve_for_waiting, from any thread.
    virtual void end_serving() = 0;
    /// Makes the threads that wait in calls of the participant check again.
    virtual void notify_waiting() = 0;
  };
  /// `server` must exist until `close` returns. If the system has no timer, the participant's
  /// thread keeps the turn.
  explicit ServingTurn(Server& server);

  enum class WaitReason : std::uint8_t {
    data,  ///< the thread may serve while it waits
    other  ///< the participant's thread serves
  };
  /// A wait of the calling thread, from its construction until its destruction.
  class WaitScope {
   public:
    /// `set` is the wait set whose condition variable the thread waits on; nullptr if it waits in a
    /// call of the participant.
    WaitScope(ServingTurn& turn, WaitReason reason, std::shared_ptr<WaitSetState> set = {});
    ~WaitScope();
    WaitScope(const WaitScope&) = delete;
    WaitScope& operator=(const WaitScope&) = delete;
    /// True if the thread has the turn and must call `serve`; false if another thread serves. The
    /// caller holds the mutex of its condition variable until it waits, so that no notification is
    /// lost.
    bool serves();
    /// Serves for at most `timeout`. The caller holds no lock.
    void serve(std::chrono::nanoseconds timeout) {
      turn_.server_.serve_for_waiting(std::min(timeout, kMaxServe), *this);
    }
    /// Returns false if the participant's thread has taken the turn away. Otherwise it cannot do so
    /// until `end_work`, which must follow.
    bool begin_work() { return turn_.progress_.compare_exchange_strong(progress_, progress_ + 1); }
    void end_work() { turn_.progress_.store(progress_ += 2); }

   private:
    friend class ServingTurn;
    ServingTurn& turn_;
    const bool may_serve_;
    const std::shared_ptr<WaitSetState> set_;
    bool serves_ = false;         ///< as far as this thread knows
    std::uint64_t progress_ = 0;  ///< while it serves: its last value of ServingTurn::progress_
    WaitScope* next_ = nullptr;
  };

  // For the participant's thread:
  /// Waits for the turn. Returns false after `close`.
  bool await();
  /// Returns how long it may wait for sockets and timers.
  std::chrono::nanoseconds longest_own() const;
  /// Gives the turn to a thread that waits, or to none after `close`. Returns false if the
  /// participant's thread keeps it.
  bool yield();

  /// Soon gives the turn to the participant's thread, for a while.
  void prefer_own(std::chrono::nanoseconds how_long);
  /// Returns true if no thread serves. The participant's thread then serves at once.
  bool take_over();
  /// Ends the wait of the thread that serves, if it is an application thread.
  void wake() { server_.end_serving(); }
  /// Gives no thread the turn any more. Returns when no application thread serves.
  void close();

 private:
  enum class Holder : std::uint8_t { none, own, application };

  // The caller holds the mutex:
  void add(WaitScope& waiting);
  void remove(WaitScope& waiting);
  void give_up(Clock::time_point now);
  void arm(std::chrono::nanoseconds after);
  bool may_begin(Clock::time_point now);
  void note_displaced(WaitScope& waiting);

  // For the participant's thread:
  /// The progress that it has seen of the application thread that serves.
  struct Watch {
    std::uint64_t progress = ~0ull;  ///< at first a value that progress_ never has at rest
    Clock::time_point since{};
  };
  bool take_from_held(Watch& watch, Clock::time_point now);
  bool sleep() const;

  Server& server_;
  const FileDescriptor timer_;  ///< wakes the participant's thread while it does not serve
  std::mutex mutex_;            ///< a leaf: no other lock is taken with it
  std::condition_variable given_up_;
  Holder holder_ = Holder::own;
  const WaitScope* leader_ = nullptr;  ///< set if an application thread has the turn
  /// The number of threads whose turn was taken away while they served, and that still serve.
  std::atomic<int> displaced_ = 0;
  /// Increases whenever an application thread gets the turn, its work begins or ends, or its turn
  /// is taken away. An odd value means that it works.
  std::atomic<std::uint64_t> progress_ = 0;
  bool is_closed_ = false, is_due_at_once_ = false, is_armed_ = false;
  /// True if the last wait began less than kGrace after the one before.
  bool returns_soon_ = false;
  WaitScope* list_ = nullptr;
  std::size_t count_ = 0;
  Clock::time_point given_up_at_{}, last_end_{}, last_turn_{}, own_until_{};
};

}  // namespace ddssec::rtps
