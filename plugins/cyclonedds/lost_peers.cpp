// The part of the authentication adapter for peers that have lost their session, or never got one.
#include <dlfcn.h>
#include <iterator>
#include <thread>

#include "plugins/cyclonedds/authentication_adapter.hpp"
#include "plugins/cyclonedds/datagrams.hpp"
#include "plugins/cyclonedds/process_questions.hpp"

namespace ddssec::cyclonedds {

namespace {
constexpr const char* kGrowingIntervals =
    "from now on it is begun again at growing intervals; this event is not repeated, but Cyclone "
    "DDS may log each attempt";
constexpr std::size_t kMaxEndedByPeer = 1024;
constexpr std::size_t kMaxPresented = 32;  // documents in force since rights changed
constexpr const char* kOnce = "this is done once; then the handshake waits for the peer";
}  // namespace

void AuthenticationAdapter::revoke_stuck(const std::stop_token& stop, const Revoke& revoke) {
  // Per second: attackers can invent peers that never answer.
  constexpr int kMaxDisposeAnnouncements = 32;
  int announcements = 0;
  for (const auto& stuck : watch_.give_up(questions_to_cryptography())) {
    if (stop.stop_requested()) return;
    if (!stuck.lacks_endpoints && ++announcements <= kMaxDisposeAnnouncements)
      send_dispose_announcement(stuck.guid);
    if (stuck.is_first) {
      const auto waited = std::chrono::duration_cast<std::chrono::milliseconds>(stuck.waited);
      const std::string found = stuck.lacks_endpoints ? "not all of its builtin endpoints"
                                : stuck.was_disturbed ? "a refused message and then nothing"
                                                      : "nothing";
      const std::string shared = stuck.is_shared
                                     ? ", although the peer authenticated another participant of "
                                       "this process, whose session ends now and begins again"
                                     : "";
      host_->notice(
          Event(Error(Code::handshake_begun_again,
                      {.document = "the handshake with a discovered participant",
                       .expected = "that it ends",
                       .found = found + " for " + std::to_string(waited.count()) + " ms" + shared,
                       .note = stuck.is_once ? kOnce : kGrowingIntervals}),
                {}, stuck.guid.to_string(),
                // A peer that lacks endpoints has finished its handshake; all others may be
                // invented by an attacker.
                stuck.lacks_endpoints || stuck.is_shared ? PeerProof::authenticated
                                                         : PeerProof::claimed));
    }
    revoke(stuck.remote.value);
  }
}

// No dispose announcement is sent if unauthenticated participants are admitted, because the peer
// may be matched as one of them.
void AuthenticationAdapter::send_dispose_announcement(const Guid& peer) {
  for (const auto& local : dispose_announcements_.locals()) {
    if (!remotes_.has_discovered(local.handle, peer) || admits_unauthenticated(local.handle))
      continue;
    const auto announcement = write_dispose_announcement(local.prefix, peer.prefix);
    send_to_discovery(announcement);
    send_datagram(announcement, lost_sessions_.addresses_of(peer));
  }
}

void AuthenticationAdapter::cut_off_peer(spi::IdentityHandle remote, const Revoke& revoke) {
  if (const auto guid = remotes_.guid(remote)) lost_sessions_.about_to_cut_off(*guid);
  revoke(remote.value);
}

// A reset ends the sessions of all local participants with that peer, and these reset the peer in
// turn. All of that has to be over before new sessions begin, or it would end those as well.
void AuthenticationAdapter::follow_resets(const std::stop_token& stop, const Revoke& revoke,
                                          bool resets_peers) {
  constexpr int kMaxTurns = 20;
  constexpr std::chrono::milliseconds kPause{50};
  if (!revoke_reset(stop, revoke) && !resets_peers) return;
  for (int turn = 0; turn < kMaxTurns && !stop.stop_requested(); ++turn) {
    send_resets();
    std::this_thread::sleep_for(kPause);
    revoke_reset(stop, revoke);
  }
}

// Also notes peers whose handshake is under way, because it presents the former permissions however
// late the peer answers. A handshake that was under way when the host dropped its peer goes on if
// the host discovers the peer again soon, so peers are noted for a while. Ends only sessions with
// peers that follow a reset: other peers would keep their side of the session, and ignore each new
// handshake.
void AuthenticationAdapter::note_changed_rights(spi::IdentityHandle local, std::uint64_t changes) {
  auto& known = rights_changes_[local];
  const auto now = host_->clock().monotonic();
  const bool has_changed = changes > known.count;
  if (has_changed) known = {changes, now};
  const auto current = presented_.find(local);
  const bool is_known = current != presented_.end();
  if (known.presented.size() >= kMaxPresented) known.presented.clear();
  if (is_known) known.presented.insert(current->second);
  // If it is not known what is presented, each new session would count as one of the former ones.
  const bool is_recent = is_known && known.count > 0 && now - known.noted < kept_handshake_;
  if (!has_changed && !is_recent) return;
  for (const auto& [remote, guid] : remotes_.all())
    if (remotes_.has_discovered(local, guid)) endings_[{guid, local}] = now;
}

// Both sides of a session may get renewed permissions at the same time, and each ends the session
// that it knows. A session that began after that has presented the renewed ones, or yet later ones.
// It must not end: its handshake may be under way on the other side, which would wait for 20 s.
bool AuthenticationAdapter::take_noted(const Guid& remote, std::chrono::nanoseconds now) {
  // The time until the other side has finished, too, and follows a reset.
  constexpr auto kFinished = std::chrono::seconds(2);
  bool ends = false;
  auto at = endings_.lower_bound({remote, spi::IdentityHandle{INT64_MIN}});
  while (at != endings_.end() && at->first.first == remote) {
    const auto one = at++;
    const auto local = one->first.second;
    const auto session = lost_sessions_.session(local, remote);
    if (!session) continue;
    const auto& current = rights_changes_[local].presented;
    const bool is_current = session->presented && current.contains(*session->presented);
    if (!is_current && now - session->at < kFinished) continue;
    ends = ends || !is_current;
    endings_.erase(one);
  }
  return ends;
}

bool AuthenticationAdapter::revoke_noted(const std::stop_token& stop, const Revoke& revoke) {
  if (endings_.empty()) return false;
  const auto now = host_->clock().monotonic();
  bool any = false;
  for (const auto& [remote, guid] : remotes_.all()) {
    if (stop.stop_requested()) return any;
    if (!take_noted(guid, now)) continue;
    lost_sessions_.about_to_drop(guid);
    revoke(remote.value);
    any = true;
  }
  std::erase_if(endings_, [&](const auto& entry) {
    const auto& [pair, noted] = entry;
    const auto& [guid, local] = pair;
    return now - noted >= kept_handshake_ && !lost_sessions_.has_session(local, guid) &&
           !remotes_.has_discovered(local, guid);
  });
  return any;
}

bool AuthenticationAdapter::revoke_reset(const std::stop_token& stop, const Revoke& revoke) {
  // Without libddssec_cryptography no peer can prove that it lost its session.
  void* const symbol = dlsym(RTLD_DEFAULT, kTakeSessionResetSymbol);
  if (symbol == nullptr) return false;
  bool any = false;
  for (const auto& [remote, guid] : remotes_.all()) {
    if (stop.stop_requested()) return any;
    const auto reset = reinterpret_cast<TakeSessionReset*>(symbol)(remote.value);
    if (reset == SessionReset::none) continue;
    if (reset == SessionReset::of_unused_session && !watch_.follows_unused_reset(guid)) continue;
    if (!was_just_ended(guid))
      host_->notice(Event(Error(Code::session_reset_by_peer), {}, guid.to_string(),
                          PeerProof::authenticated));
    if (ended_by_peer_.size() < kMaxEndedByPeer)
      ended_by_peer_.try_emplace(guid, EndedSession{host_->clock().monotonic()});
    lost_sessions_.about_to_drop(guid);
    revoke(remote.value);
    any = true;
  }
  return any;
}

// A reset is sent to several addresses, so copies of it arrive before the host has dropped the
// peer.
bool AuthenticationAdapter::was_just_ended(const Guid& guid) const {
  constexpr std::chrono::seconds kCopies{1};
  const auto ended = ended_by_peer_.find(guid);
  return ended != ended_by_peer_.end() && host_->clock().monotonic() - ended->second.at < kCopies;
}

void AuthenticationAdapter::report_ended_by_peer() {
  for (auto at = ended_by_peer_.begin(); at != ended_by_peer_.end();)
    at = is_settled(at->first, at->second) ? ended_by_peer_.erase(at) : std::next(at);
}

bool AuthenticationAdapter::is_settled(const Guid& guid, EndedSession& end) {
  constexpr std::chrono::seconds kMemory{60};
  const auto now = host_->clock().monotonic();
  bool is_discovered = false, is_in_session = false;
  for (const auto& local : dispose_announcements_.locals()) {
    is_discovered = is_discovered || remotes_.has_discovered(local.handle, guid);
    is_in_session = is_in_session || lost_sessions_.has_session(local.handle, guid);
  }
  if (end.is_dropped && is_in_session) return true;
  end.is_dropped = end.is_dropped || !is_in_session;
  if (!end.is_dropped || !is_discovered) return now - end.at > kMemory;
  if (!end.discovered) end.discovered = now;
  if (now - *end.discovered < patience_) return false;
  const auto waited = std::chrono::duration_cast<std::chrono::seconds>(patience_);
  host_->notice(
      Event(Error(Code::session_not_resumed,
                  {.document = "the session with a participant",
                   .expected = "that the peer authenticates us again",
                   .found = "no new session for " + std::to_string(waited.count()) + " s"}),
            {}, guid.to_string(), PeerProof::authenticated));
  return true;
}

void AuthenticationAdapter::revoke_stranded(const std::stop_token& stop, const Revoke& revoke) {
  void* const symbol = dlsym(RTLD_DEFAULT, kTakeStrandedKeysSymbol);
  if (symbol == nullptr) return;
  for (const auto& [remote, guid] : remotes_.all()) {
    if (stop.stop_requested()) return;
    if (!reinterpret_cast<TakeStrandedKeys*>(symbol)(remote.value)) continue;
    host_->notice(
        Event(Error(Code::session_begun_again), {}, guid.to_string(), PeerProof::authenticated));
    revoke(remote.value);
  }
}

void AuthenticationAdapter::send_resets() {
  const auto has_discovered = [&](auto local, const auto& guid) {
    return remotes_.has_discovered(local, guid);
  };
  for (const auto& reset : lost_sessions_.due(has_discovered)) {
    send_datagram(reset.message, reset.to);
    if (!reset.discovers)
      own_announcements_.note_reset(reset.local, reset.remote, reset.to,
                                    host_->clock().monotonic());
    // The local host may not discover the peer because it believes that the peer has no security.
    // The peer's host may believe the same about the local participant.
    if (!reset.discovers && !admits_unauthenticated(reset.local))
      send_datagram(write_dispose_announcement(reset.own, reset.remote.prefix), reset.to);
  }
}

// A participant that is cut off stays so, and a host that discovers the peer needs no answer of it.
void AuthenticationAdapter::send_announcements() {
  for (const auto& one : own_announcements_.take_due(host_->clock().monotonic()))
    if (!remotes_.has_ended(one.local) && !remotes_.has_discovered(one.local, one.peer))
      send_datagram(one.message, one.to);
}

}  // namespace ddssec::cyclonedds
