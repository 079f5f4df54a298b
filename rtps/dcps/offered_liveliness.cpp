#include "rtps/dcps/offered_liveliness.hpp"

#include <algorithm>

namespace ddssec::rtps {

void ManualLiveliness::assert_all(MonotonicTime now, bool explicitly) {
  auto shortest = kNever;
  for (auto* writer : writers_) {
    writer->renew(now);
    shortest = std::min(shortest, writer->lease_duration());
  }
  if (shortest == kNever || (!explicitly && now < next_announcement_)) return;
  next_announcement_ = now + shortest / 3;
  announce_(now);
}

void OfferedLiveliness::start(const Liveliness& liveliness, MonotonicTime now) {
  policy_ = liveliness;
  lease_.emplace(liveliness, now);
  call_at(lease_->next_tick());
  if (liveliness.kind == LivelinessKind::manual_by_participant) of_participant_.add(*this);
}

void OfferedLiveliness::stop() {
  of_participant_.remove(*this);
  cancel();
}

void OfferedLiveliness::assert_at(MonotonicTime now, bool explicitly) {
  switch (policy_.kind) {
    case LivelinessKind::automatic:
      return;
    case LivelinessKind::manual_by_participant:
      return of_participant_.assert_all(now, explicitly);
    case LivelinessKind::manual_by_topic:
      return renew(now);
  }
}

void OfferedLiveliness::renew(MonotonicTime now) {
  lease_->assert_at(now);
  call_at(lease_->next_tick());
}

void OfferedLiveliness::on_time(MonotonicTime now) {
  if (lease_->expire(now)) lost_();
  call_at(lease_->next_tick());
}

}  // namespace ddssec::rtps
