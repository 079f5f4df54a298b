#include "rtps/dcps/liveliness.hpp"

#include <algorithm>

namespace ddssec::rtps {
namespace {

MonotonicTime lease_of(Duration lease) {
  return lease.is_infinite() ? kNever : lease.to_nanoseconds();
}

}  // namespace

WriterLease::WriterLease(const Liveliness& liveliness, MonotonicTime now)
    : lease_(liveliness.kind == LivelinessKind::automatic ? kNever
                                                          : lease_of(liveliness.lease_duration)),
      asserted_(now) {}

void WriterLease::assert_at(MonotonicTime now) {
  asserted_ = now;
  is_lost_ = false;
}

bool WriterLease::expire(MonotonicTime now) {
  if (now < next_tick()) return false;
  is_lost_ = true;
  return true;
}

void LivelinessMonitor::set_lease(Writer& writer, MonotonicTime lease) {
  const bool counted = writer.lease != kNever;
  writer.lease = lease;
  if (counted == (lease != kNever)) return;
  auto& of_identity = of_identity_[writer.identity];
  counted ? --of_identity : ++of_identity;
  if (of_identity == 0) of_identity_.erase(writer.identity);
}

MonotonicTime LivelinessMonitor::end_of(const Writer& writer) const {
  if (writer.lease == kNever) return kNever;
  const auto writers = static_cast<std::int64_t>(of_identity_.at(writer.identity));
  const auto asserted =
      writer.signal ? std::max(writer.asserted, writer.signal->latest()) : writer.asserted;
  return asserted + std::max({writer.lease, kMinLease, kMinLeasePerWriter * writers});
}

void LivelinessMonitor::schedule(const Guid& guid, Writer& writer) {
  unschedule(guid, writer);
  writer.noted_end = end_of(writer);
  if (writer.noted_end != kNever) ends_.insert({writer.noted_end, guid});
}

void LivelinessMonitor::unschedule(const Guid& guid, Writer& writer) {
  if (writer.noted_end != kNever) ends_.erase({writer.noted_end, guid});
  writer.noted_end = kNever;
}

void LivelinessMonitor::count(const Guid& writer, int alive, int not_alive) {
  status_.alive_count += alive;
  status_.alive_count_change += alive;
  status_.not_alive_count += not_alive;
  status_.not_alive_count_change += not_alive;
  status_.last_remote = writer;
  has_changed_ = true;
}

void LivelinessMonitor::add(const Guid& writer, Duration lease, MonotonicTime now,
                            const std::optional<GuidPrefix>& identity) {
  const auto [at, is_new] = writers_.try_emplace(writer);
  if (is_new) at->second.identity = identity.value_or(writer.prefix);
  if (is_new) at->second.asserted = now;
  set_lease(at->second, lease_of(lease));
  if (at->second.is_alive) schedule(writer, at->second);
  if (is_new) count(writer, 1, 0);
}

void LivelinessMonitor::follow(const Guid& writer, std::shared_ptr<LivelinessSignal> signal) {
  const auto at = writers_.find(writer);
  if (at == writers_.end()) return;
  at->second.signal = std::move(signal);
  if (at->second.is_alive) schedule(writer, at->second);
}

void LivelinessMonitor::remove(const Guid& writer) {
  const auto at = writers_.find(writer);
  if (at == writers_.end()) return;
  const bool was_alive = at->second.is_alive;
  unschedule(writer, at->second);
  set_lease(at->second, kNever);
  writers_.erase(at);
  count(writer, was_alive ? -1 : 0, was_alive ? 0 : -1);
}

void LivelinessMonitor::note_alive(const Guid& writer, MonotonicTime now) {
  const auto at = writers_.find(writer);
  if (at == writers_.end()) return;
  at->second.asserted = now;
  if (std::exchange(at->second.is_alive, true)) return;
  schedule(writer, at->second);
  count(writer, 1, -1);
}

// An assertion does not move the noted end, so each lease is checked once per lease duration.
void LivelinessMonitor::expire(MonotonicTime now, const OnEnd& ended) {
  while (next_tick() <= now) {
    const auto guid = ends_.begin()->second;
    auto& writer = writers_.find(guid)->second;
    schedule(guid, writer);
    if (writer.noted_end > now) continue;
    unschedule(guid, writer);
    writer.is_alive = false;
    count(guid, -1, 1);
    ended(guid, writer.signal.get());
  }
}

bool LivelinessMonitor::is_alive(const Guid& writer) const {
  const auto at = writers_.find(writer);
  return at != writers_.end() && at->second.is_alive;
}

void LivelinessMonitor::reset_changes() {
  status_.alive_count_change = status_.not_alive_count_change = 0;
}

}  // namespace ddssec::rtps
