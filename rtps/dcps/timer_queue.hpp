// Who wants to be called when. No thread and no clock of its own.
#pragma once

#include <set>
#include <utility>

#include "rtps/reliability/stateful_writer.hpp"

namespace ddssec::rtps {

class TimerQueue;

/// Something that has to be done at a time.
class Timed {
 public:
  virtual ~Timed() { cancel(); }
  Timed(const Timed&) = delete;
  Timed& operator=(const Timed&) = delete;

 protected:
  explicit Timed(TimerQueue& queue) : queue_(queue) {}
  /// Its time has come, or a little earlier: it looks what is due, and says when it wants to be
  /// called again.
  virtual void on_time(MonotonicTime now) = 0;
  /// To be called at `when` at the latest; a later time than the one wanted before is ignored.
  void call_at(MonotonicTime when);
  /// Leaves the queue; whoever shares it among threads does this before it dies, with the lock.
  void cancel();

 private:
  friend class TimerQueue;
  TimerQueue& queue_;
  MonotonicTime wanted_ = kNever;
};

class TimerQueue {
 public:
  MonotonicTime next() const { return queue_.empty() ? kNever : queue_.begin()->first; }
  void run(MonotonicTime now) {
    while (next() <= now) {
      auto& timed = *queue_.begin()->second;
      queue_.erase(queue_.begin());
      timed.wanted_ = kNever;
      timed.on_time(now);
    }
  }

 private:
  friend class Timed;
  std::set<std::pair<MonotonicTime, Timed*>> queue_;
};

inline void Timed::cancel() {
  if (wanted_ != kNever) queue_.queue_.erase({wanted_, this});
  wanted_ = kNever;
}

inline void Timed::call_at(MonotonicTime when) {
  if (when >= wanted_) return;
  cancel();
  wanted_ = when;
  queue_.queue_.emplace(when, this);
}

}  // namespace ddssec::rtps
