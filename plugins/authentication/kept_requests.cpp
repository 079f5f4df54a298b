#include "plugins/authentication/kept_requests.hpp"

#include <algorithm>

namespace ddssec::authentication {

void KeptRequests::keep(Pair& pair, MonotonicTime now) {
  const auto waits = [](const PairHandshake& one) {
    return std::holds_alternative<AwaitReply>(one.state);
  };
  const std::scoped_lock lock(pair.mutex, mutex_);
  const auto found = std::ranges::find_if(pair.handshakes, waits);
  if (found == pair.handshakes.end()) return;
  make_room(now);
  all_.insert_or_assign({pair.local_handle, pair.remote_guid},
                        Kept{pair.own_challenge, std::move(*found)});
}

void KeptRequests::make_room(MonotonicTime now) {
  std::erase_if(all_,
                [&](const auto& entry) { return now - entry.second.handshake.since > kLife; });
  if (all_.size() < kMost) return;
  all_.erase(std::ranges::min_element(
      all_, {}, [](const auto& entry) { return entry.second.handshake.since; }));
}

std::optional<spi::Challenge> KeptRequests::challenge(spi::IdentityHandle local, const Guid& remote,
                                                      MonotonicTime now) {
  const std::lock_guard lock(mutex_);
  const auto found = all_.find({local, remote});
  if (found == all_.end()) return std::nullopt;
  if (now - found->second.handshake.since <= kLife) return found->second.challenge;
  all_.erase(found);
  return std::nullopt;
}

std::optional<PairHandshake> KeptRequests::take(spi::IdentityHandle local, const Guid& remote) {
  const std::lock_guard lock(mutex_);
  auto node = all_.extract({local, remote});
  if (node.empty()) return std::nullopt;
  return std::move(node.mapped().handshake);
}

void KeptRequests::forget(spi::IdentityHandle local) {
  const std::lock_guard lock(mutex_);
  std::erase_if(all_, [&](const auto& entry) { return entry.first.first == local; });
}

}  // namespace ddssec::authentication
