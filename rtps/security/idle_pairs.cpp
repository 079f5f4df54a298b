#include "rtps/security/idle_pairs.hpp"

#include <algorithm>

namespace ddssec::rtps {

std::optional<Guid> IdlePairs::add(const Guid& remote, IdleReason why) {
  if (const auto known = places_.find(remote); known != places_.end() && known->second.why == why)
    return std::nullopt;
  remove(remote);
  auto& share = shares_[SubjectShares::subject_of(remote.prefix)];
  auto& queue = share.queues[static_cast<std::size_t>(why)];
  queue.push_back(remote);
  places_[remote] = {why, std::prev(queue.end())};
  if (queue.size() <= kMaxOfOne) return std::nullopt;
  const auto oldest = queue.front();
  share.has_displaced = true;
  remove(oldest);
  return oldest;
}

void IdlePairs::remove(const Guid& remote) {
  const auto known = places_.find(remote);
  if (known == places_.end()) return;
  const auto share = shares_.find(SubjectShares::subject_of(remote.prefix));
  auto& queues = share->second.queues;
  queues[static_cast<std::size_t>(known->second.why)].erase(known->second.at);
  places_.erase(known);
  // A share that has displaced pairs is kept: such a pair may match later, even if no other pair of
  // its subject is idle then.
  if (!share->second.has_displaced && std::ranges::all_of(queues, &Queue::empty))
    shares_.erase(share);
}

bool IdlePairs::has_displaced(const GuidPrefix& subject) const {
  const auto share = shares_.find(SubjectShares::subject_of(subject));
  return share != shares_.end() && share->second.has_displaced;
}

}  // namespace ddssec::rtps
