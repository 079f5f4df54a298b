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
  lost_ = false;
}

bool WriterLease::check(MonotonicTime now) {
  if (now < next_tick()) return false;
  lost_ = true;
  return true;
}

void LivelinessMonitor::count(const Guid& writer, int alive, int not_alive) {
  status_.alive_count += alive;
  status_.alive_count_change += alive;
  status_.not_alive_count += not_alive;
  status_.not_alive_count_change += not_alive;
  status_.last_publication_handle = writer;
  changed_ = true;
}

void LivelinessMonitor::add(const Guid& writer, Duration lease, MonotonicTime now) {
  const auto [at, is_new] = writers_.try_emplace(writer);
  at->second.lease = lease_of(lease);
  if (!is_new) return;
  at->second.asserted = now;
  count(writer, 1, 0);
}

void LivelinessMonitor::remove(const Guid& writer) {
  const auto at = writers_.find(writer);
  if (at == writers_.end()) return;
  const bool was_alive = at->second.alive;
  writers_.erase(at);
  count(writer, was_alive ? -1 : 0, was_alive ? 0 : -1);
}

void LivelinessMonitor::alive(const Guid& writer, MonotonicTime now) {
  const auto at = writers_.find(writer);
  if (at == writers_.end()) return;
  at->second.asserted = now;
  if (std::exchange(at->second.alive, true)) return;
  count(writer, 1, -1);
}

void LivelinessMonitor::check(MonotonicTime now, const std::function<void(const Guid&)>& ended) {
  for (auto& [guid, writer] : writers_) {
    if (!writer.alive || writer.lease == kNever || now < writer.asserted + writer.lease) continue;
    writer.alive = false;
    count(guid, -1, 1);
    ended(guid);
  }
}

MonotonicTime LivelinessMonitor::next_tick() const {
  auto next = kNever;
  for (const auto& [guid, writer] : writers_)
    if (writer.alive && writer.lease != kNever)
      next = std::min(next, writer.asserted + writer.lease);
  return next;
}

bool LivelinessMonitor::is_alive(const Guid& writer) const {
  const auto at = writers_.find(writer);
  return at != writers_.end() && at->second.alive;
}

void LivelinessMonitor::reset_changes() {
  status_.alive_count_change = status_.not_alive_count_change = 0;
}

}  // namespace ddssec::rtps
