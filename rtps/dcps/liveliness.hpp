// LIVELINESS on both sides (DDS 1.4, 2.2.3.11): a writer's own lease, and the leases of the writers
// that a reader matched. No I/O, clock or lock.
#pragma once

#include <functional>
#include <map>

#include "base/clock.hpp"
#include "rtps/dcps/status.hpp"
#include "rtps/qos/qos.hpp"

namespace ddssec::rtps {

/// A local writer must assert itself before its lease ends; an AUTOMATIC one always does.
class WriterLease {
 public:
  WriterLease(const Liveliness& liveliness, MonotonicTime now);

  void assert_at(MonotonicTime now);
  /// True once for each time that the lease ran out.
  bool check(MonotonicTime now);
  MonotonicTime next_tick() const {
    return lost_ || lease_ == kNever ? kNever : asserted_ + lease_;
  }

 private:
  MonotonicTime lease_ = kNever;
  MonotonicTime asserted_{};
  bool lost_ = false;
};

/// Which of a reader's writers live.
class LivelinessMonitor {
 public:
  /// A matched writer is alive at first.
  void add(const Guid& writer, Duration lease, MonotonicTime now);
  void remove(const Guid& writer);
  /// It asserted itself.
  void alive(const Guid& writer, MonotonicTime now);
  /// Calls `ended` for each writer whose lease ran out.
  void check(MonotonicTime now, const std::function<void(const Guid&)>& ended);
  MonotonicTime next_tick() const;

  bool is_alive(const Guid& writer) const;
  const LivelinessChangedStatus& status() const { return status_; }
  void reset_changes();
  /// True if the status changed since this was last asked.
  bool take_changed() { return std::exchange(changed_, false); }

 private:
  struct Writer {
    MonotonicTime lease = kNever;
    MonotonicTime asserted{};
    bool alive = true;
  };
  void count(const Guid& writer, int alive, int not_alive);

  std::map<Guid, Writer> writers_;
  LivelinessChangedStatus status_;
  bool changed_ = false;
};

}  // namespace ddssec::rtps
