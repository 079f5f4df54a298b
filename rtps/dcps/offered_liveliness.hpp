// LIVELINESS that the DataWriters of a participant offer (DDS 1.4, 2.2.3.11). The caller holds the
// participant's lock.
#pragma once

#include <functional>
#include <set>

#include "rtps/dcps/liveliness.hpp"
#include "rtps/reliability/timer_queue.hpp"

namespace ddssec::rtps {

class OfferedLiveliness;

/// The writers of a participant with LIVELINESS MANUAL_BY_PARTICIPANT: what asserts one of them
/// asserts all.
class ManualLiveliness {
 public:
  /// `announce` tells the other participants.
  explicit ManualLiveliness(std::function<void(MonotonicTime now)> announce)
      : announce_(std::move(announce)) {}

  void add(OfferedLiveliness& writer) { writers_.insert(&writer); }
  void remove(OfferedLiveliness& writer) { writers_.erase(&writer); }
  /// One of them wrote, or the application said `explicitly` that they live. Nothing without
  /// writers. Samples assert the participant to the readers that they reach; the others must hear
  /// it too, but not with every sample: they are told at most three times in the shortest lease.
  void assert_all(MonotonicTime now, bool explicitly);

 private:
  std::function<void(MonotonicTime now)> announce_;
  std::set<OfferedLiveliness*> writers_;
  MonotonicTime next_announcement_{};  ///< unless it is explicit
};

/// The lease of one writer, with a timer of its own.
class OfferedLiveliness final : private Timed {
 public:
  /// `lost` is called once for each time that the lease runs out. `timers` and `of_participant`
  /// outlive this.
  OfferedLiveliness(TimerQueue& timers, ManualLiveliness& of_participant,
                    std::function<void()> lost)
      : Timed(timers), of_participant_(of_participant), lost_(std::move(lost)) {}

  /// The writer is enabled: its lease begins.
  void start(const Liveliness& liveliness, MonotonicTime now);
  /// Before it dies.
  void stop();
  /// The writer wrote, or the application said `explicitly` that it lives.
  void assert_at(MonotonicTime now, bool explicitly);
  MonotonicTime lease_duration() const { return policy_.lease_duration.to_nanoseconds(); }

 private:
  friend class ManualLiveliness;
  void renew(MonotonicTime now);
  void on_time(MonotonicTime now) override;

  ManualLiveliness& of_participant_;
  std::function<void()> lost_;
  Liveliness policy_;
  std::optional<WriterLease> lease_;  ///< nothing: not enabled
};

}  // namespace ddssec::rtps
