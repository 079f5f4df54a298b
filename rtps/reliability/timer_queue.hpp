// The times at which objects need to be called. No thread or clock of its own.
#pragma once

#include <cstddef>
#include <vector>

#include "base/clock.hpp"

namespace ddssec::rtps {

class TimerQueue;

/// An object that must be called at certain times.
class TimedObject {
 public:
  virtual ~TimedObject() { cancel(); }
  TimedObject(const TimedObject&) = delete;
  TimedObject& operator=(const TimedObject&) = delete;

 protected:
  /// Without a queue, the owner calls the object at times of its own choice.
  explicit TimedObject(TimerQueue* queue) : queue_(queue) {}
  explicit TimedObject(TimerQueue& queue) : queue_(&queue) {}
  /// Called at the requested time or a little earlier. The implementation checks what is due, and
  /// requests its next call.
  virtual void on_time(MonotonicTime now) = 0;
  /// Requests a call at `when` at the latest. A time later than the one already requested is
  /// ignored.
  void call_at(MonotonicTime when);
  /// Leaves the queue. An object that several threads share must call this, with the lock held,
  /// before it is destroyed.
  void cancel();

 private:
  friend class TimerQueue;
  TimerQueue* queue_;
  MonotonicTime wanted_ = kNever;
  std::size_t place_ = 0;  ///< index in the queue, if a call is requested
};

/// A heap whose members know their indexes, so that no member has to be searched for. Memory is
/// allocated only for more members than ever before.
class TimerQueue {
 public:
  MonotonicTime next() const { return heap_.empty() ? kNever : heap_.front()->wanted_; }
  void run(MonotonicTime now) {
    while (next() <= now) {
      auto& timed = *heap_.front();
      timed.cancel();
      RetryGuard again{timed, now + kRetry};
      timed.on_time(now);
      again.is_needed = false;
    }
  }

 private:
  friend class TimedObject;
  static constexpr MonotonicTime kRetry = std::chrono::milliseconds(100);
  /// If an exception ends work that was due, its object is due again.
  struct RetryGuard {
    ~RetryGuard() {
      if (!is_needed) return;
      try {
        timed.call_at(when);
      } catch (...) {
        return;  // there is no memory for this either
      }
    }
    TimedObject& timed;
    const MonotonicTime when;
    bool is_needed = true;
  };
  void put(std::size_t place, TimedObject* timed) {
    heap_[place] = timed;
    timed->place_ = place;
  }
  void raise(std::size_t place, TimedObject* timed) {
    for (; place > 0 && timed->wanted_ < heap_[(place - 1) / 2]->wanted_; place = (place - 1) / 2)
      put(place, heap_[(place - 1) / 2]);
    put(place, timed);
  }
  void sink(std::size_t place, TimedObject* timed) {
    for (auto child = 2 * place + 1; child < heap_.size(); child = 2 * place + 1) {
      if (child + 1 < heap_.size() && heap_[child + 1]->wanted_ < heap_[child]->wanted_) ++child;
      if (timed->wanted_ <= heap_[child]->wanted_) break;
      put(place, heap_[child]);
      place = child;
    }
    put(place, timed);
  }
  /// Adds an object at the end. Its time is still kNever, so the order of the heap holds. If memory
  /// runs out, nothing has changed.
  void add(TimedObject* timed) {
    heap_.push_back(timed);
    timed->place_ = heap_.size() - 1;
  }
  void remove(std::size_t place) {
    auto* last = heap_.back();
    heap_.pop_back();
    if (place == heap_.size()) return;
    sink(place, last);
    raise(last->place_, last);
  }

  std::vector<TimedObject*> heap_;
};

inline void TimedObject::cancel() {
  if (wanted_ == kNever) return;
  queue_->remove(place_);
  wanted_ = kNever;
}

inline void TimedObject::call_at(MonotonicTime when) {
  if (when >= wanted_ || queue_ == nullptr) return;
  if (wanted_ == kNever) queue_->add(this);
  wanted_ = when;
  queue_->raise(place_, this);
}

}  // namespace ddssec::rtps
