#include "plugins/cyclonedds/lost_sessions.hpp"

#include <algorithm>

namespace ddssec::cyclonedds {

using spi::IdentityHandle;

void LostSessions::add_local(IdentityHandle local, const GuidPrefix& prefix) {
  const std::lock_guard lock(mutex_);
  locals_[local] = prefix;
}

void LostSessions::remove_local(IdentityHandle local) {
  const std::lock_guard lock(mutex_);
  locals_.erase(local);
  std::erase_if(sessions_, [&](const auto& entry) {
    if (entry.first.second != local) return false;
    if (entry.second.is_lost) --lost_;
    return true;
  });
}

void LostSessions::established(IdentityHandle local, const Guid& remote,
                               const spi::SharedSecret& secret) {
  const std::lock_guard lock(mutex_);
  const auto own = locals_.find(local);
  if (own == locals_.end()) return;
  Session session{.sender = own->second,
                  .token = spi::derive_reset_token(secret, own->second),
                  .to = secret.peer_addresses};
  if (session.to.size() > kMostAddresses) session.to.resize(kMostAddresses);
  auto& known = sessions_[{remote, local}];
  if (known.is_lost) --lost_;
  known = std::move(session);
}

void LostSessions::lost(const Guid& remote) {
  const std::lock_guard lock(mutex_);
  const auto now = clock_.monotonic();
  for (auto at = sessions_.lower_bound({remote, IdentityHandle{INT64_MIN}});
       at != sessions_.end() && at->first.first == remote; ++at) {
    if (at->second.is_lost) continue;
    at->second.is_lost = true;
    at->second.lost_at = at->second.next = now;
    ++lost_;
  }
  make_room();
}

void LostSessions::forget_lost_before(Duration time) {
  std::erase_if(sessions_, [&](const auto& entry) {
    if (!entry.second.is_lost || entry.second.lost_at > time) return false;
    --lost_;
    return true;
  });
}

void LostSessions::make_room() {
  while (lost_ > kMostLost) {
    auto first = sessions_.end();
    for (auto at = sessions_.begin(); at != sessions_.end(); ++at)
      if (at->second.is_lost &&
          (first == sessions_.end() || at->second.lost_at < first->second.lost_at))
        first = at;
    sessions_.erase(first);
    --lost_;
  }
}

std::vector<LostSessions::Due> LostSessions::due(const IsMeeting& is_meeting) {
  const std::lock_guard lock(mutex_);
  if (lost_ == 0) return {};
  const auto now = clock_.monotonic();
  forget_lost_before(now - kMemory);
  std::vector<Due> out;
  for (auto& [key, session] : sessions_) {
    if (!session.is_lost || session.next > now) continue;
    if (!is_meeting(key.second, key.first)) continue;
    ++session.sent;
    session.next = now + (session.sent < kSoon ? kInterval : kLongInterval);
    out.push_back({spi::write_reset(session.sender, session.token), session.to});
  }
  return out;
}

std::vector<spi::UdpAddress> LostSessions::addresses_of(const Guid& remote) {
  const std::lock_guard lock(mutex_);
  const auto at = sessions_.lower_bound({remote, IdentityHandle{INT64_MIN}});
  return at != sessions_.end() && at->first.first == remote ? at->second.to
                                                            : std::vector<spi::UdpAddress>();
}

}  // namespace ddssec::cyclonedds
