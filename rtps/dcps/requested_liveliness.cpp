#include "rtps/dcps/requested_liveliness.hpp"

namespace ddssec::rtps {

void RequestedLiveliness::add_writer(const Guid& writer, Duration lease, MonotonicTime now,
                                     const std::optional<GuidPrefix>& identity) {
  monitor_.add(writer, lease, now, identity);
  update();
}

void RequestedLiveliness::remove_writer(const Guid& writer) {
  monitor_.remove(writer);
  update();
}

// A writer that is announced again while it is not alive still waits for its next assertion.
void RequestedLiveliness::on_signal(const Guid& writer, std::shared_ptr<LivelinessSignal> signal) {
  if (signal && !monitor_.is_alive(writer)) signal->notify(reader_, writer);
  monitor_.follow(writer, std::move(signal));
  update();
}

void RequestedLiveliness::on_alive(const Guid& writer, MonotonicTime now) {
  monitor_.note_alive(writer, now);
  update();
}

LivelinessChangedStatus RequestedLiveliness::read_status() {
  changes_.clear(StatusKind::liveliness_changed);
  const auto status = monitor_.status();
  monitor_.reset_changes();
  return status;
}

void RequestedLiveliness::on_time(MonotonicTime now) {
  std::vector<Guid> ended;
  monitor_.expire(now, [&](const Guid& writer, LivelinessSignal* signal) {
    if (signal != nullptr) signal->notify(reader_, writer);
    ended.push_back(writer);
  });
  if (!ended.empty()) lost_(ended, now);
  update();
}

void RequestedLiveliness::update() {
  call_at(monitor_.next_tick());
  if (monitor_.take_changed()) changes_.note(StatusKind::liveliness_changed);
}

}  // namespace ddssec::rtps
