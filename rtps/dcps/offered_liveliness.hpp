// LIVELINESS offered by the DataWriters of a participant (DDS 1.4, 2.2.3.11). The caller holds the
// participant's lock.
#pragma once

#include <functional>
#include <set>

#include "rtps/dcps/liveliness.hpp"
#include "rtps/reliability/timer_queue.hpp"

namespace ddssec::rtps {

class OfferedLiveliness;

/// The writers of a participant with LIVELINESS MANUAL_BY_PARTICIPANT. Asserting one of them
/// asserts all.
class ManualLiveliness {
 public:
  /// `announce` sends the assertion to the other participants.
  explicit ManualLiveliness(std::function<void(MonotonicTime now)> announce)
      : announce_(std::move(announce)) {}

  void add(OfferedLiveliness& writer) { writers_.insert(&writer); }
  void remove(OfferedLiveliness& writer) { writers_.erase(&writer); }
  /// Called when one of the writers wrote, or when the application asserted them `explicitly`. Does
  /// nothing if there are no writers. A sample asserts the participant to the readers that it
  /// reaches. The other participants need an announcement, but not with every sample: they get at
  /// most three in the shortest lease.
  void assert_all(MonotonicTime now, bool explicitly);

 private:
  std::function<void(MonotonicTime now)> announce_;
  std::set<OfferedLiveliness*> writers_;
  /// The earliest time for the next announcement that is not explicit.
  MonotonicTime next_announcement_{};
};

/// The lease of one writer, with its own timer.
class OfferedLiveliness final : private TimedObject {
 public:
  /// `lost` is called once for each time that the lease runs out. `timers` and `of_participant`
  /// must outlive this object.
  OfferedLiveliness(TimerQueue& timers, ManualLiveliness& of_participant,
                    std::function<void()> lost)
      : TimedObject(timers), of_participant_(of_participant), lost_(std::move(lost)) {}

  /// Begins the lease, because the writer is enabled.
  void start(const Liveliness& liveliness, MonotonicTime now);
  /// Call it before destruction.
  void stop();
  /// Notes that the writer wrote, or that the application asserted it `explicitly`.
  void assert_at(MonotonicTime now, bool explicitly);
  MonotonicTime lease_duration() const { return policy_.lease_duration.to_nanoseconds(); }

 private:
  friend class ManualLiveliness;
  void renew(MonotonicTime now);
  void on_time(MonotonicTime now) override;

  ManualLiveliness& of_participant_;
  std::function<void()> lost_;
  Liveliness policy_;
  std::optional<WriterLease> lease_;  ///< empty until the writer is enabled
};

}  // namespace ddssec::rtps
