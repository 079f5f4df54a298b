// LIVELINESS on both sides (DDS 1.4, 2.2.3.11): a writer's own lease, and the leases of a reader's
// matched writers. No I/O, clock or lock.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>

#include "base/clock.hpp"
#include "rtps/dcps/status.hpp"
#include "rtps/participant/liveliness_signal.hpp"
#include "rtps/qos/qos.hpp"

namespace ddssec::rtps {

/// The lease of a local writer, which must assert its liveliness before the lease ends. With
/// AUTOMATIC liveliness it never ends.
class WriterLease {
 public:
  WriterLease(const Liveliness& liveliness, MonotonicTime now);

  void assert_at(MonotonicTime now);
  /// Returns true once for each time that the lease ran out.
  bool expire(MonotonicTime now);
  MonotonicTime next_tick() const {
    return is_lost_ || lease_ == kNever ? kNever : asserted_ + lease_;
  }

 private:
  MonotonicTime lease_ = kNever;
  MonotonicTime asserted_{};
  bool is_lost_ = false;
};

/// Tracks which of a reader's writers are alive. The cost of an assertion or a tick does not grow
/// with the number of writers: a lease is checked only when it would have ended.
class LivelinessMonitor {
 public:
  /// Shorter leases are treated as this one, because each end of a lease and each return causes
  /// work.
  static constexpr MonotonicTime kMinLease = std::chrono::milliseconds(1);
  /// No lease of an identity ends sooner than this time for each of its writers with a finite
  /// lease. So all of them together cause at most so much work, however short their leases are:
  /// one message can assert all writers of a participant, and so let all their leases end again.
  static constexpr MonotonicTime kMinLeasePerWriter = std::chrono::microseconds(125);

  /// Adds a matched writer, which is alive at first. `identity` is that of its participant; if it
  /// is empty, each participant counts as an identity.
  void add(const Guid& writer, Duration lease, MonotonicTime now,
           const std::optional<GuidPrefix>& identity = {});
  /// Makes this signal assert the writer as well, instead of a former one. nullptr means no signal.
  void follow(const Guid& writer, std::shared_ptr<LivelinessSignal> signal);
  void remove(const Guid& writer);
  /// Notes that the writer asserted its liveliness.
  void note_alive(const Guid& writer, MonotonicTime now);
  /// Calls `ended` for each writer whose lease ran out, with its signal, or nullptr if it has none.
  using OnEnd = std::function<void(const Guid&, LivelinessSignal*)>;
  void expire(MonotonicTime now, const OnEnd& ended);
  /// Returns a time before which no lease ends.
  MonotonicTime next_tick() const { return ends_.empty() ? kNever : ends_.begin()->first; }

  bool is_alive(const Guid& writer) const;
  const LivelinessChangedStatus& status() const { return status_; }
  void reset_changes();
  /// Returns true if the status changed since the last call.
  bool take_changed() { return std::exchange(has_changed_, false); }

 private:
  struct Writer {
    GuidPrefix identity;
    MonotonicTime lease = kNever;
    MonotonicTime asserted{};
    bool is_alive = true;
    std::shared_ptr<LivelinessSignal> signal = {};
    MonotonicTime noted_end = kNever;  ///< its time in ends_; kNever if it is not in ends_
  };
  void set_lease(Writer& writer, MonotonicTime lease);
  /// Returns the time at which its lease ends, as far as is known now.
  MonotonicTime end_of(const Writer& writer) const;
  /// Schedules a check at the time when its lease ends, as far as is known now.
  void schedule(const Guid& guid, Writer& writer);
  void unschedule(const Guid& guid, Writer& writer);
  void count(const Guid& writer, int alive, int not_alive);

  std::map<Guid, Writer> writers_;
  /// For each writer that is alive, the time at which its lease ends, or an earlier one. It is
  /// later by at most 125 us for each writer of its identity that has left meanwhile.
  std::set<std::pair<MonotonicTime, Guid>> ends_;
  std::map<GuidPrefix, std::size_t> of_identity_;  ///< number of writers with a finite lease
  LivelinessChangedStatus status_;
  bool has_changed_ = false;
};

}  // namespace ddssec::rtps
