#include "rtps/participant/announcement_refresh.hpp"

#include <algorithm>

namespace ddssec::rtps {

void AnnouncementRefresh::note_change(MonotonicTime now) {
  if (due_ != kNever) return;
  if (now >= last_ + kMaxPause) pause_ = kMinPause;
  due_ = now + pause_;
}

// A participant may also send again that an endpoint has ended. That confirms an end which does not
// count yet.
bool AnnouncementRefresh::note_end(const EntityId& endpoint, MonotonicTime now) {
  note_change(now);
  if (const auto at = ended_.find(endpoint); at != ended_.end()) {
    at->second.is_read &= !at->second.counts;
    return at->second.counts;
  }
  std::erase(gone_, endpoint);
  const bool counts = counting_ < kMaxEnded;
  ended_.emplace(endpoint, State{counts});
  counting_ += counts ? 1 : 0;
  return counts;
}

void AnnouncementRefresh::note_alive(const EntityId& endpoint) {
  const auto at = ended_.find(endpoint);
  if (at == ended_.end()) return;
  counting_ -= at->second.counts ? 1 : 0;
  ended_.erase(at);
}

bool AnnouncementRefresh::begin_refresh_if_due(MonotonicTime now) {
  if (now < std::min(due_, routine_)) return false;
  // If the routine refresh comes first while a change waits, the pause grows as for changes that go
  // on.
  pause_ = due_ == kNever ? kMinPause : std::min(pause_ * 2, kMaxPause);
  due_ = kNever;
  last_ = now;
  if (routine_ != kNever) routine_ = now + kMaxPause;
  for (auto& [endpoint, state] : ended_) state.is_read = true;
  over_ = now + kAnswerTimeout;
  return true;
}

bool AnnouncementRefresh::end_refresh_if_over(MonotonicTime now) {
  if (now < over_) return false;
  over_ = kNever;
  return true;
}

std::vector<AnnouncementRefresh::EndedEndpoint> AnnouncementRefresh::take_confirmed_ends() {
  std::vector<EndedEndpoint> out;
  std::erase_if(ended_, [&](const auto& ended) {
    const auto& [endpoint, state] = ended;
    if (!state.is_read) return false;
    out.push_back({endpoint, state.counts});
    counting_ -= state.counts ? 1 : 0;
    return true;
  });
  return out;
}

std::optional<EntityId> AnnouncementRefresh::note_gone(const EntityId& endpoint) {
  gone_.push_back(endpoint);
  if (gone_.size() <= kMaxGone) return std::nullopt;
  const auto first = gone_.front();
  gone_.pop_front();
  if (without_keys_.size() >= kMaxWithoutKeys) without_keys_.erase(without_keys_.begin());
  without_keys_[first] = false;
  return first;
}

MonotonicTime AnnouncementRefresh::next() const { return std::min({due_, over_, routine_}); }

}  // namespace ddssec::rtps
