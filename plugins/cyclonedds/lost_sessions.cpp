#include "plugins/cyclonedds/lost_sessions.hpp"

#include <algorithm>

namespace ddssec::cyclonedds {

using spi::IdentityHandle;

LostSessions::Subject LostSessions::subject_of(const Key& key) {
  Subject subject;
  std::copy_n(key.first.prefix.octets.begin(), subject.size(), subject.begin());
  return subject;
}

void LostSessions::add_local(IdentityHandle local, const GuidPrefix& prefix) {
  const std::lock_guard lock(mutex_);
  locals_[local].prefix = prefix;
}

std::vector<LostSessions::Reset> LostSessions::remove_local(IdentityHandle local) {
  const std::lock_guard lock(mutex_);
  std::vector<Reset> out;
  if (locals_.erase(local) == 0) return out;
  std::erase_if(sessions_, [&](const auto& entry) {
    const auto& [key, session] = entry;
    if (key.second != local) return false;
    out.push_back({spi::write_reset(session.sender, session.token), session.to});
    return true;
  });
  return out;
}

void LostSessions::established(IdentityHandle local, const Guid& remote,
                               const spi::SharedSecret& secret, const Presented& presented) {
  const std::lock_guard lock(mutex_);
  const auto own = locals_.find(local);
  if (own == locals_.end()) return;
  const auto& sender = own->second.prefix;
  Session session{.sender = sender,
                  .token = spi::derive_reset_token(secret, sender),
                  .to = secret.peer_addresses,
                  .begun = {clock_.monotonic(), presented}};
  if (session.to.size() > kMaxAddresses) session.to.resize(kMaxAddresses);
  const Key key{remote, local};
  auto& known = sessions_[key];
  forget_loss(key, known);
  known = std::move(session);
}

void LostSessions::lost(const Guid& remote) {
  const std::lock_guard lock(mutex_);
  auto at = sessions_.lower_bound({remote, IdentityHandle{INT64_MIN}});
  while (at != sessions_.end() && at->first.first == remote) {
    const Key key = at->first;
    // This call may drop this session or the next one.
    if (at->second.lost == 0) note_lost(key, at->second);
    at = sessions_.upper_bound(key);
  }
}

void LostSessions::about_to_drop(const Guid& remote) { reset_after(remote, Duration{}); }

void LostSessions::about_to_cut_off(const Guid& remote) { reset_after(remote, kFirstOfCutOff); }

void LostSessions::reset_after(const Guid& remote, Duration wait) {
  const std::lock_guard lock(mutex_);
  auto at = sessions_.lower_bound({remote, IdentityHandle{INT64_MIN}});
  for (; at != sessions_.end() && at->first.first == remote; ++at)
    at->second.first_undiscovered = wait;
}

void LostSessions::note_lost(const Key& key, Session& session) {
  auto& local = locals_.at(key.second);
  auto& of_subject = local.lost[subject_of(key)];
  of_subject.emplace(losses_ + 1, key);
  session.lost = ++losses_;
  session.lost_at = session.discovered_at = session.next = clock_.monotonic();
  ++local.all_lost;
  if (of_subject.size() > kMaxOfSubject) return forget_first(of_subject);
  if (local.all_lost <= kMaxLost) return;
  const auto most_then_first = [](const auto& entry) {
    const auto& sessions = entry.second;
    return std::pair(sessions.size(), sessions.empty() ? 0 : ~sessions.begin()->first);
  };
  forget_first(std::ranges::max_element(local.lost, {}, most_then_first)->second);
}

void LostSessions::forget_loss(const Key& key, Session& session) {
  if (session.lost == 0) return;
  auto& local = locals_.at(key.second);
  const auto of_subject = local.lost.find(subject_of(key));
  of_subject->second.erase({session.lost, key});
  if (of_subject->second.empty()) local.lost.erase(of_subject);
  session.lost = 0;
  --local.all_lost;
}

void LostSessions::forget_first(const InOrder& in_order) {
  const auto session = sessions_.find(in_order.begin()->second);
  forget_loss(session->first, session->second);
  sessions_.erase(session);
}

LostSessions::Duration LostSessions::wait_while_undiscovered(const Session& session) {
  if (session.sent_undiscovered > 0)
    return kSecondUndiscovered * (1 << (session.sent_undiscovered - 1));
  return session.first_undiscovered;
}

bool LostSessions::is_due(const Session& session, bool discovers, Duration now) {
  if (session.lost == 0) return false;
  return discovers ? session.next <= now
                   : session.lost_at + wait_while_undiscovered(session) <= now;
}

void LostSessions::note_sent(Session& session, bool discovers, Duration now) {
  if (!discovers) {
    ++session.sent_undiscovered;
  } else {
    ++session.sent;
    session.next = now + (session.sent < kSoon ? kInterval : kLongInterval);
  }
}

std::vector<LostSessions::DueReset> LostSessions::due(const Discovers& discovers) {
  const std::lock_guard lock(mutex_);
  if (std::ranges::all_of(locals_, [](const auto& one) { return one.second.all_lost == 0; }))
    return {};
  const auto now = clock_.monotonic();
  std::vector<DueReset> out;
  unsigned undiscovered = 0;
  for (auto at = sessions_.begin(); at != sessions_.end();) {
    const auto entry = at++;
    auto& [key, session] = *entry;
    if (session.lost == 0) continue;
    const auto& [remote, local] = key;
    const bool is_discovered = discovers(local, remote);
    if (is_discovered) session.discovered_at = now;
    if (session.discovered_at <= now - kMemory) {
      forget_loss(key, session);
      sessions_.erase(entry);
      continue;
    }
    if (!is_due(session, is_discovered, now)) continue;
    if (!is_discovered && ++undiscovered > kMaxUndiscovered) continue;
    note_sent(session, is_discovered, now);
    out.push_back({.local = local,
                   .own = session.sender,
                   .remote = remote,
                   .discovers = is_discovered,
                   .message = spi::write_reset(session.sender, session.token),
                   .to = session.to});
  }
  return out;
}

std::optional<LostSessions::Begun> LostSessions::session(IdentityHandle local,
                                                         const Guid& remote) const {
  const std::lock_guard lock(mutex_);
  const auto session = sessions_.find({remote, local});
  if (session == sessions_.end() || session->second.lost != 0) return std::nullopt;
  return session->second.begun;
}

std::vector<spi::UdpAddress> LostSessions::addresses_of(const Guid& remote) {
  const std::lock_guard lock(mutex_);
  const auto at = sessions_.lower_bound({remote, IdentityHandle{INT64_MIN}});
  return at != sessions_.end() && at->first.first == remote ? at->second.to
                                                            : std::vector<spi::UdpAddress>();
}

}  // namespace ddssec::cyclonedds
