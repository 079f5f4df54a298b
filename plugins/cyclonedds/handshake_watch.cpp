#include "plugins/cyclonedds/handshake_watch.hpp"

#include <algorithm>

namespace ddssec::cyclonedds {

using spi::HandshakeHandle;
using spi::IdentityHandle;

void HandshakeWatch::note_discovered(WatchedPair pair, const Guid& guid, CoreTimerState timer) {
  const std::lock_guard lock(mutex_);
  const auto now = clock_.monotonic();
  auto& known = remotes_.try_emplace(pair.remote, Remote{guid, now}).first->second;
  known.since = now;
  auto& half = known.unfinished.try_emplace(pair.local, LocalHandshake{now, timer}).first->second;
  half.asked_again.reset();
  if (timer == CoreTimerState::stopped) half.discovered = now;
}

void HandshakeWatch::note_not_admitted(WatchedPair pair, const Guid& guid, CoreTimerState timer) {
  const std::lock_guard lock(mutex_);
  const auto now = clock_.monotonic();
  auto& known = remotes_.try_emplace(pair.remote, Remote{guid, now}).first->second;
  known.was_disturbed = true;
  known.unfinished.try_emplace(pair.local, LocalHandshake{now, timer}).first->second.asked_again =
      now;
}

bool HandshakeWatch::was_unanswered(const Guid& remote) const {
  const std::lock_guard lock(mutex_);
  const auto past = past_.find(remote);
  return past != past_.end() && past->second.was_longest;
}

void HandshakeWatch::note_progress(WatchedPair pair, HandshakeHandle handshake) {
  const std::lock_guard lock(mutex_);
  const auto known = remotes_.find(pair.remote);
  if (known == remotes_.end()) return;
  known->second.since = clock_.monotonic();
  known->second.is_under_way = true;
  handshakes_[handshake] = pair;
}

HandshakeWatch::Remote* HandshakeWatch::of(HandshakeHandle handshake) {
  const auto known = handshakes_.find(handshake);
  if (known == handshakes_.end()) return nullptr;
  const auto remote = remotes_.find(known->second.remote);
  return remote == remotes_.end() ? nullptr : &remote->second;
}

void HandshakeWatch::note_refused(IdentityHandle remote) {
  const std::lock_guard lock(mutex_);
  if (const auto known = remotes_.find(remote); known != remotes_.end())
    known->second.was_disturbed = true;
}

void HandshakeWatch::note_refused(HandshakeHandle handshake) {
  const std::lock_guard lock(mutex_);
  if (auto* const remote = of(handshake)) remote->was_disturbed = true;
}

void HandshakeWatch::note_finished(HandshakeHandle handshake) {
  const std::lock_guard lock(mutex_);
  auto* const remote = of(handshake);
  if (remote == nullptr) return;
  remote->is_finished = true;
  remote->since = clock_.monotonic();
  const auto half = remote->unfinished.find(handshakes_.at(handshake).local);
  if (half != remote->unfinished.end()) half->second.is_finished = true;
}

void HandshakeWatch::note_session_kept(HandshakeHandle handshake) {
  const std::lock_guard lock(mutex_);
  if (auto* const remote = of(handshake)) remote->keeps_session = true;
}

bool HandshakeWatch::follows_unused_reset(const Guid& remote) {
  const std::lock_guard lock(mutex_);
  const auto now = clock_.monotonic();
  const auto last = begun_again_.find(remote);
  if (last != begun_again_.end() && now - last->second < kUnusedResets) return false;
  note_begun_again(remote, now);
  return true;
}

// The memory is bounded. If an entry is lost, the worst result is one more interruption.
void HandshakeWatch::note_begun_again(const Guid& remote, Duration now) {
  if (!begun_again_.contains(remote) && begun_again_.size() >= kMaxPeers)
    begun_again_.erase(
        std::ranges::min_element(begun_again_, {}, [](const auto& entry) { return entry.second; }));
  begun_again_[remote] = now;
}

void HandshakeWatch::forget(HandshakeHandle handshake) {
  const std::lock_guard lock(mutex_);
  handshakes_.erase(handshake);
}

void HandshakeWatch::forget(IdentityHandle participant) {
  const std::lock_guard lock(mutex_);
  remotes_.erase(participant);
  for (auto& [handle, remote] : remotes_) remote.unfinished.erase(participant);
  std::erase_if(handshakes_, [&](const auto& entry) {
    return entry.second.remote == participant || entry.second.local == participant;
  });
}

HandshakeWatch::Duration HandshakeWatch::timeout(const Remote& remote) const {
  auto wait = remote.was_disturbed && !remote.is_under_way ? kTimeoutAfterRefusal : kTimeout;
  const auto past = past_.find(remote.guid);
  for (unsigned i = 0; past != past_.end() && i < past->second.times && wait < kMaxWait; ++i)
    wait *= 2;
  return std::min(wait, kMaxWait);
}

// A peer can lack endpoints only after its handshake has ended. The time since it was discovered
// does not count then.
bool HandshakeWatch::is_stuck(const Remote& remote, Duration now) const {
  if (remote.is_settled) return false;
  if (!remote.lacks_endpoints && now - remote.discovered >= kMaxWait) return true;
  return now - remote.since >= timeout(remote);
}

// The memory is bounded. An attacker that invents GUIDs makes it forget those that were given up
// longest ago.
HandshakeWatch::PastWaits& HandshakeWatch::past_of(const Guid& guid, Duration now) {
  if (!past_.contains(guid) && past_.size() >= kMaxPeers)
    past_.erase(
        std::ranges::min_element(past_, {}, [](const auto& entry) { return entry.second.last; }));
  auto& past = past_[guid];
  past.last = now;
  return past;
}

void HandshakeWatch::await_keys(IdentityHandle handle, Remote& remote, const Questions& ask) const {
  if (remote.keeps_session && !remote.was_disturbed) remote.since = clock_.monotonic();
  if (ask.last_heard) remote.since = std::max(remote.since, ask.last_heard(handle));
}

bool HandshakeWatch::is_settled(IdentityHandle handle, Remote& remote, const Questions& ask) const {
  if (!remote.is_finished) return false;
  if (remote.is_settled) {
    if (!ask.is_matched || ask.is_matched(handle)) return true;
    remote.since = clock_.monotonic();
    remote.lacks_endpoints = true;
    return false;
  }
  remote.lacks_endpoints = false;
  if (ask.has_keys && !ask.has_keys(handle)) {
    await_keys(handle, remote, ask);
    return false;
  }
  remote.lacks_endpoints = ask.is_matched && !ask.is_matched(handle);
  return !remote.lacks_endpoints;
}

// True if the handshake of one pair must begin again. It must in any case if the core's timer runs
// for it.
bool HandshakeWatch::begin_pair_again(const LocalHandshake& half, const Remote& remote) {
  constexpr auto kAsksNoMore = std::chrono::seconds(10);  // the host asks once a second
  const auto now = clock_.monotonic();
  if (now - half.discovered < kMaxWait) return false;
  if (half.timer == CoreTimerState::runs) return true;
  const bool is_asked = half.asked_again && now - *half.asked_again < kAsksNoMore;
  if (is_asked || remote.keeps_session || begun_again_.contains(remote.guid)) return false;
  note_begun_again(remote.guid, now);
  return true;
}

// Gives up the handshakes of other local participants with a peer that has a session with one.
bool HandshakeWatch::give_up_pairs(IdentityHandle handle, const Remote& remote,
                                   std::vector<StuckHandshake>& out) {
  const auto now = clock_.monotonic();
  for (const auto& [local, half] : remote.unfinished) {
    if (!begin_pair_again(half, remote)) continue;
    out.push_back({.remote = handle,
                   .guid = remote.guid,
                   .was_disturbed = remote.was_disturbed,
                   .lacks_endpoints = false,
                   .is_first = true,
                   .waited = now - half.discovered,
                   .is_shared = true,
                   .is_once = half.timer == CoreTimerState::stopped});
    return true;
  }
  return false;
}

void HandshakeWatch::note_finished(IdentityHandle handle, Remote& remote, const Questions& ask) {
  std::erase_if(remote.unfinished, [&](const auto& entry) {
    const auto& [local, half] = entry;
    return half.is_finished && (!ask.has_keys_for || ask.has_keys_for(handle, local));
  });
  if (remote.unfinished.empty()) begun_again_.erase(remote.guid);
}

std::vector<HandshakeWatch::StuckHandshake> HandshakeWatch::give_up(const Questions& ask) {
  const std::lock_guard lock(mutex_);
  const auto now = clock_.monotonic();
  std::erase_if(past_, [&](const auto& entry) { return now - entry.second.last > kForgetAfter; });
  std::vector<StuckHandshake> out;
  for (auto& [handle, remote] : remotes_) {
    remote.is_settled = is_settled(handle, remote, ask);
    note_finished(handle, remote, ask);
    const bool has_session = remote.is_settled || remote.lacks_endpoints;
    if (has_session && give_up_pairs(handle, remote, out)) continue;
    if (!is_stuck(remote, now)) continue;
    auto& past = past_of(remote.guid, now);
    out.push_back({handle, remote.guid, remote.was_disturbed, remote.lacks_endpoints,
                   past.times == 0, now - remote.since});
    ++past.times;
    past.was_longest = !remote.lacks_endpoints && now - remote.discovered >= kMaxWait;
  }
  for (const auto& stuck : out) {
    remotes_.erase(stuck.remote);
    std::erase_if(handshakes_,
                  [&](const auto& entry) { return entry.second.remote == stuck.remote; });
  }
  return out;
}

}  // namespace ddssec::cyclonedds
