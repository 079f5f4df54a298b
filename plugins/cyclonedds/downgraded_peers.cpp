#include "plugins/cyclonedds/downgraded_peers.hpp"

#include <algorithm>

namespace ddssec::cyclonedds {

void DowngradedPeers::note(const Guid& peer, std::chrono::nanoseconds now) {
  const std::lock_guard lock(mutex_);
  std::erase_if(since_, [&](const auto& one) { return now - one.second >= kTime; });
  const auto since = [](const auto& one) { return one.second; };
  if (since_.size() >= kMaxPeers && !since_.contains(peer))
    since_.erase(std::ranges::min_element(since_, {}, since));
  since_[peer] = now;
}

bool DowngradedPeers::contains(const Guid& peer, std::chrono::nanoseconds now) const {
  const std::lock_guard lock(mutex_);
  const auto found = since_.find(peer);
  return found != since_.end() && now - found->second < kTime;
}

}  // namespace ddssec::cyclonedds
