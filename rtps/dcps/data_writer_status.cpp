// AnyDataWriter, the half that statuses, listeners and timers are about.
#include "rtps/dcps/domain_participant.hpp"
#include "rtps/dcps/publisher.hpp"

namespace ddssec::rtps {

void AnyDataWriter::on_time(MonotonicTime now) {
  instances_->check_deadlines(now, [&](InstanceHandle instance) { miss_deadline(instance); });
  if (lease_.check(now)) {
    liveliness_lost_.count();
    note(StatusKind::liveliness_lost);
  }
  for (; !expiring_.empty() && expiring_.front().first <= now; expiring_.pop_front())
    protocol().discard(expiring_.front().second);
  call_at(std::min({instances_->next_deadline(), lease_.next_tick(),
                    expiring_.empty() ? kNever : expiring_.front().first}));
  context_.notify();  // what was discarded made room
}

LivelinessLostStatus AnyDataWriter::liveliness_lost_status() {
  return read_status(StatusKind::liveliness_lost, liveliness_lost_);
}

void AnyDataWriter::set_listener(DataWriterListener* listener, StatusMask mask) {
  const std::lock_guard callbacks(context_.callbacks());
  const auto held = lock();
  listening_ = {listener, mask};
}

DataWriterListener* AnyDataWriter::listener_for(StatusKind kind) const {
  if (auto* own = listening_.for_status(kind)) return own;
  if (auto* group = publisher().listening_.for_status(kind)) return group;
  return publisher().participant().listening_.for_status(kind);
}

void AnyDataWriter::tell_listeners() {
  const auto listener = [this](StatusKind kind) {
    const auto held = lock();
    return has_changed(kind) ? listener_for(kind) : nullptr;
  };
  if (auto* l = listener(StatusKind::publication_matched))
    l->on_publication_matched(*this, publication_matched_status());
  if (auto* l = listener(StatusKind::offered_incompatible_qos))
    l->on_offered_incompatible_qos(*this, offered_incompatible_qos_status());
  if (auto* l = listener(StatusKind::offered_deadline_missed))
    l->on_offered_deadline_missed(*this, offered_deadline_missed_status());
  if (auto* l = listener(StatusKind::liveliness_lost))
    l->on_liveliness_lost(*this, liveliness_lost_status());
}

}  // namespace ddssec::rtps
