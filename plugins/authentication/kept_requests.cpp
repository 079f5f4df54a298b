#include "plugins/authentication/kept_requests.hpp"

#include <algorithm>
#include <array>
#include <iterator>

namespace ddssec::authentication {

// The keys are kept without the peer's credentials, whose size the peer chose. The caller holds the
// pair's lock.
std::vector<ReplyKey> KeptRequests::reply_keys(IdentityPair& pair) {
  auto out = std::move(pair.reply_keys);
  for (auto& one : pair.handshakes)
    if (auto* state = std::get_if<AwaitFinal>(&one.state))
      out.push_back({std::move(state->key), std::move(state->transcript)});
  if (out.size() > kMaxReplyKeys) out.erase(out.begin(), out.end() - kMaxReplyKeys);
  return out;
}

void KeptRequests::keep(IdentityPair& pair, MonotonicTime now) {
  const auto has_ended = [](const PairHandshake& one) {
    return std::holds_alternative<EstablishedSession>(one.state);
  };
  const auto waits = [](const PairHandshake& one) {
    return std::holds_alternative<AwaitReply>(one.state);
  };
  const std::scoped_lock lock(pair.mutex, mutex_);
  if (std::ranges::any_of(pair.handshakes, has_ended)) return;
  Entry kept{pair.own_challenge, now};
  const auto request = std::ranges::find_if(pair.handshakes, waits);
  if (request != pair.handshakes.end()) {
    kept.since = request->began_at;
    kept.held.request = std::move(*request);
  }
  kept.held.reply_keys = reply_keys(pair);
  make_room(now);
  all_.insert_or_assign({pair.local_handle, pair.remote_guid}, std::move(kept));
}

void KeptRequests::make_room(MonotonicTime now) {
  std::erase_if(all_, [&](const auto& entry) { return now - entry.second.since > kLife; });
  if (all_.size() < kMax) return;
  std::array<std::uint8_t, 2> chance{};
  static_assert(kMax <= 1u << 8 * chance.size());
  if (!random_.fill(chance)) chance = {};
  all_.erase(std::next(all_.begin(), (chance[0] << 8 | chance[1]) % std::ssize(all_)));
}

std::optional<spi::Challenge> KeptRequests::challenge(spi::IdentityHandle local, const Guid& remote,
                                                      MonotonicTime now) {
  const std::lock_guard lock(mutex_);
  const auto found = all_.find({local, remote});
  if (found == all_.end()) return std::nullopt;
  if (now - found->second.since <= kLife) return found->second.challenge;
  all_.erase(found);
  return std::nullopt;
}

KeptRequests::KeptHandshake KeptRequests::take(spi::IdentityHandle local, const Guid& remote) {
  const std::lock_guard lock(mutex_);
  auto node = all_.extract({local, remote});
  if (node.empty()) return {};
  return std::move(node.mapped().held);
}

void KeptRequests::forget(spi::IdentityHandle local) {
  const std::lock_guard lock(mutex_);
  std::erase_if(all_, [&](const auto& entry) { return entry.first.first == local; });
}

}  // namespace ddssec::authentication
