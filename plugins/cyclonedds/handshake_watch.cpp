#include "plugins/cyclonedds/handshake_watch.hpp"

#include <algorithm>

namespace ddssec::cyclonedds {

using spi::HandshakeHandle;
using spi::IdentityHandle;

void HandshakeWatch::met(IdentityHandle remote, const Guid& guid, Duration longest_wait) {
  const std::lock_guard lock(mutex_);
  const auto now = clock_.monotonic();
  auto& known = remotes_.try_emplace(remote, Remote{guid, now}).first->second;
  known.since = now;
  known.longest_wait = longest_wait;
}

void HandshakeWatch::not_admitted(IdentityHandle remote, const Guid& guid) {
  const std::lock_guard lock(mutex_);
  remotes_.try_emplace(remote, Remote{guid, clock_.monotonic()}).first->second.was_disturbed = true;
}

void HandshakeWatch::progressed(IdentityHandle remote, HandshakeHandle handshake) {
  const std::lock_guard lock(mutex_);
  const auto known = remotes_.find(remote);
  if (known == remotes_.end()) return;
  known->second.since = clock_.monotonic();
  known->second.is_under_way = true;
  handshakes_[handshake] = remote;
}

HandshakeWatch::Remote* HandshakeWatch::of(HandshakeHandle handshake) {
  const auto known = handshakes_.find(handshake);
  if (known == handshakes_.end()) return nullptr;
  const auto remote = remotes_.find(known->second);
  return remote == remotes_.end() ? nullptr : &remote->second;
}

void HandshakeWatch::refused(IdentityHandle remote) {
  const std::lock_guard lock(mutex_);
  if (const auto known = remotes_.find(remote); known != remotes_.end())
    known->second.was_disturbed = true;
}

void HandshakeWatch::refused(HandshakeHandle handshake) {
  const std::lock_guard lock(mutex_);
  if (auto* const remote = of(handshake)) remote->was_disturbed = true;
}

void HandshakeWatch::finished(HandshakeHandle handshake) {
  const std::lock_guard lock(mutex_);
  auto* const remote = of(handshake);
  if (remote == nullptr) return;
  remote->is_finished = true;
  remote->since = clock_.monotonic();
}

void HandshakeWatch::keeps_its_session(HandshakeHandle handshake) {
  const std::lock_guard lock(mutex_);
  if (auto* const remote = of(handshake)) remote->keeps_its_session = true;
}

void HandshakeWatch::forget(HandshakeHandle handshake) {
  const std::lock_guard lock(mutex_);
  handshakes_.erase(handshake);
}

void HandshakeWatch::forget(IdentityHandle remote) {
  const std::lock_guard lock(mutex_);
  remotes_.erase(remote);
  std::erase_if(handshakes_, [&](const auto& entry) { return entry.second == remote; });
}

HandshakeWatch::Duration HandshakeWatch::patience(const Remote& remote) const {
  auto wait = remote.was_disturbed && !remote.is_under_way ? kPatience : kLongPatience;
  const auto past = past_.find(remote.guid);
  for (unsigned i = 0; past != past_.end() && i < past->second.times && wait < remote.longest_wait;
       ++i)
    wait *= 2;
  return std::min(wait, remote.longest_wait);
}

/// Endpoints can be missing only after the end of the handshake.
bool HandshakeWatch::is_stuck(const Remote& remote, Duration now) const {
  if (remote.is_settled) return false;
  if (!remote.lacks_endpoints && now - remote.met >= remote.longest_wait) return true;
  return now - remote.since >= patience(remote);
}

/// The memory is bounded: an attacker that invents GUIDs makes it forget those that were given up
/// longest ago.
HandshakeWatch::Past& HandshakeWatch::past_of(const Guid& guid, Duration now) {
  if (!past_.contains(guid) && past_.size() >= kMaxPeers)
    past_.erase(
        std::ranges::min_element(past_, {}, [](const auto& entry) { return entry.second.last; }));
  auto& past = past_[guid];
  past.last = now;
  return past;
}

void HandshakeWatch::await_keys(IdentityHandle handle, Remote& remote, const Questions& ask) const {
  if (remote.keeps_its_session && !remote.was_disturbed) remote.since = clock_.monotonic();
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

std::vector<HandshakeWatch::Stuck> HandshakeWatch::give_up(const Questions& ask) {
  const std::lock_guard lock(mutex_);
  const auto now = clock_.monotonic();
  std::erase_if(past_, [&](const auto& entry) { return now - entry.second.last > kForgetAfter; });
  std::vector<Stuck> out;
  for (auto& [handle, remote] : remotes_) {
    remote.is_settled = is_settled(handle, remote, ask);
    if (!is_stuck(remote, now)) continue;
    auto& past = past_of(remote.guid, now);
    out.push_back({handle, remote.guid, remote.was_disturbed, remote.lacks_endpoints,
                   past.times == 0, now - remote.since});
    ++past.times;
  }
  for (const auto& stuck : out) {
    remotes_.erase(stuck.remote);
    std::erase_if(handshakes_, [&](const auto& entry) { return entry.second == stuck.remote; });
  }
  return out;
}

}  // namespace ddssec::cyclonedds
