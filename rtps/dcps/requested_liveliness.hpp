// LIVELINESS requested by a DataReader (DDS 1.4, 2.2.3.11): the leases of its writers. The caller
// holds the participant's lock.
#pragma once

#include <span>

#include "rtps/dcps/liveliness.hpp"
#include "rtps/dcps/status_changes.hpp"
#include "rtps/participant/endpoint_listener.hpp"
#include "rtps/reliability/timer_queue.hpp"

namespace ddssec::rtps {

/// A LivelinessMonitor with its own timer, and the LIVELINESS_CHANGED status.
class RequestedLiveliness final : private TimedObject {
 public:
  /// Called with the writers whose leases ended.
  using Lost = std::function<void(std::span<const Guid> writers, MonotonicTime now)>;
  /// `reader` is called with the next assertion of a writer that is not alive. All arguments must
  /// outlive this object.
  RequestedLiveliness(TimerQueue& timers, EndpointListener& reader, StatusChanges& changes,
                      Lost lost)
      : TimedObject(timers), reader_(reader), changes_(changes), lost_(std::move(lost)) {}

  /// For `identity` see LivelinessMonitor::add.
  void add_writer(const Guid& writer, Duration lease, MonotonicTime now,
                  const std::optional<GuidPrefix>& identity = {});
  void remove_writer(const Guid& writer);
  /// From now on, the signal tells when the writer is alive.
  void on_signal(const Guid& writer, std::shared_ptr<LivelinessSignal> signal);
  void on_alive(const Guid& writer, MonotonicTime now);
  /// Call it before destruction.
  void stop() { cancel(); }

  /// Returns the status and resets its change counts.
  LivelinessChangedStatus read_status();

 private:
  void on_time(MonotonicTime now) override;
  void update();

  EndpointListener& reader_;
  StatusChanges& changes_;
  Lost lost_;
  LivelinessMonitor monitor_;
};

}  // namespace ddssec::rtps
