// LIVELINESS on both sides (DDS 1.4, 2.2.3.11): a writer's own lease, and the leases of the writers
// that a reader matched. No I/O, clock or lock.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <set>

#include "base/clock.hpp"
#include "rtps/dcps/status.hpp"
#include "rtps/participant/liveliness_signal.hpp"
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

/// Which of a reader's writers live. What an assertion or a tick costs does not grow with their
/// number: a lease is looked at again only when it would have ended.
class LivelinessMonitor {
 public:
  /// Shorter leases count as this one, as each end of a lease and each return is work.
  static constexpr MonotonicTime kLeastLease = std::chrono::milliseconds(1);

  /// A matched writer is alive at first.
  void add(const Guid& writer, Duration lease, MonotonicTime now);
  /// The writer is asserted by this signal, too; nullptr: by no signal.
  void follow(const Guid& writer, std::shared_ptr<LivelinessSignal> signal);
  void remove(const Guid& writer);
  /// It asserted itself.
  void alive(const Guid& writer, MonotonicTime now);
  /// Calls `ended` for each writer whose lease ran out, with its signal, if it has one.
  using Ended = std::function<void(const Guid&, LivelinessSignal*)>;
  void check(MonotonicTime now, const Ended& ended);
  /// No lease ends before.
  MonotonicTime next_tick() const { return ends_.empty() ? kNever : ends_.begin()->first; }

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
    std::shared_ptr<LivelinessSignal> signal = {};
    MonotonicTime noted_end = kNever;  ///< in ends_; never: not there
    MonotonicTime end() const;
  };
  /// Has it looked at when its lease ends, as far as is known now.
  void schedule(const Guid& guid, Writer& writer);
  void unschedule(const Guid& guid, Writer& writer);
  void count(const Guid& writer, int alive, int not_alive);

  std::map<Guid, Writer> writers_;
  std::set<std::pair<MonotonicTime, Guid>> ends_;  ///< or earlier than that: they are alive
  LivelinessChangedStatus status_;
  bool changed_ = false;
};

}  // namespace ddssec::rtps
