#include <algorithm>

#include "rtps/security/handshakes.hpp"

namespace ddssec::rtps {
namespace {

bool needs_no_tokens(const SecurityCore& core, const Peer& peer) {
  const auto* awaiting = peer.state.awaiting_keys();
  return awaiting != nullptr && awaiting->exchanges_keys &&
         !core.own->attributes().is_rtps_protected();
}

// Returns the peer that comes first now; empty if there is none. The seed is not known to others,
// so they cannot predict the choice.
std::optional<GuidPrefix> first_turn(const SecurityCore& core, std::optional<std::mt19937>& turns) {
  if (core.peers.empty()) return std::nullopt;
  if (!turns) {
    const auto secret = core.sender.amplification_limit().challenge(core.own->guid().prefix, {});
    std::seed_seq seed(secret.begin(), secret.end());
    turns.emplace(seed);
  }
  std::uniform_int_distribution<std::size_t> index(0, core.peers.size() - 1);
  return std::next(core.peers.begin(), static_cast<std::ptrdiff_t>(index(*turns)))->first;
}

}  // namespace

// The peers share budgets, and the first of them is chosen at random. Otherwise strangers could
// keep out a newcomer by GUIDs that come before its own. A due peer may be removed here. In a flood
// of announcements, only few peers are due.
void Handshakes::tick() {
  if (core_.now < next_) return;
  next_ = kNever;
  const auto tick_in = [this](const GuidPrefix& from, const std::optional<GuidPrefix>& to) {
    for (auto at = core_.peers.lower_bound(from);
         at != core_.peers.end() && (!to || at->first < *to);) {
      if (const auto due = next_of(at->second); core_.now < due) {
        next_ = std::min(next_, due);
        ++at;
        continue;
      }
      const auto prefix = at->first;
      if (core_.now >= at->second.next_attempt_at) try_again(at->second);
      if (at->second.state.handshake() != nullptr) tick(at->second);
      if (const auto* peer = core_.find(prefix)) schedule(*peer);
      at = core_.peers.upper_bound(prefix);
    }
  };
  const auto first = first_turn(core_, turns_);
  if (first) tick_in(*first, std::nullopt);
  tick_in({}, first);
}

void Handshakes::tick(Peer& peer) {
  if (core_.now >= next_admission(peer)) admit_unauthenticated(peer);
  tick_association(peer);
  auto& handshake = *peer.state.handshake();
  if (core_.now < handshake.next_tick() || !may_tick(peer)) return;
  PeerHandshake::Messages out;
  handshake.tick(core_.now, out);
  note_overdue(peer);
  send(peer, out);
  advance(peer);
}

// Announcements cost their sender nothing, and messages little, but keys cost local work.
bool Handshakes::may_tick(Peer& peer) {
  auto& handshake = *peer.state.handshake();
  if (!handshake.is_started() && !has_place(peer)) {
    handshake.start_at(core_.now + PeerHandshake::kResend);
    return false;
  }
  const auto may_start = [&] {
    return peer.has_spoken ? budgets_.may_begin_again(core_.now)
                           : budgets_.may_begin(peer.source, core_.now);
  };
  if (!handshake.is_started() && !may_start()) {
    handshake.start_at(core_.now + HandshakeBudgets::kStartPeriod);
    return false;
  }
  if (std::exchange(peer.may_send_deferred, false)) return true;
  const bool is_silent = handshake.is_started() && !peer.has_spoken;
  // One announcement is not answered again and again, because its sender may not exist.
  const bool was_heard =
      !is_silent || handshake.repetitions() < kMaxUnaskedMessages || peer.was_announced;
  if (!was_heard || (is_silent && !budgets_.may_repeat_unasked(peer.source, core_.now))) {
    handshake.start_at(core_.now + PeerHandshake::kResend);
    return false;
  }
  peer.was_announced = false;
  return true;
}

void Handshakes::tick_association(Peer& peer) {
  const auto now = core_.now;
  if (now < next_of_association(peer)) return;
  if (peer.state.joined() != nullptr) return end_probe(peer);
  const auto since = peer.state.awaiting_keys()->since;
  if (needs_no_tokens(core_, peer) && now >= since + kTokenTimeout) return exchange_.join(peer);
  if (now < since + kKeysTimeout) return;
  peer.state.on_keys_timeout(now);
  core_.host.on_unconfirmed(GuidPrefix(peer.prefix()));
  peer.state.handshake()->begin_again(now);
}

MonotonicTime Handshakes::next_of_association(const Peer& peer) const {
  if (const auto* joined = peer.state.joined()) return joined->probe_deadline;
  const auto* awaiting = peer.state.awaiting_keys();
  if (awaiting == nullptr) return kNever;
  return awaiting->since + (needs_no_tokens(core_, peer) ? kTokenTimeout : kKeysTimeout);
}

void Handshakes::end_probe(Peer& peer) {
  const auto* joined = peer.state.joined();
  if (joined == nullptr || joined->probe_deadline == kNever) return;
  peer.state.on_probe_ended();
  const bool answered = !core_.own->session_ends().has_ended(peer.prefix()) &&
                        CryptoTokenExchange::is_trusted(peer) &&
                        CryptoTokenExchange::is_up_to_date(peer);
  if (!answered && budgets_.may_begin(peer.source, core_.now))
    peer.state.handshake()->begin_again(core_.now);
  schedule(peer);
}

// The handshake does not end here: an attacker can hold messages back, or forge them.
void Handshakes::note_overdue(Peer& peer) {
  if (!peer.state.handshake()->is_overdue() || !peer.state.on_handshake_timeout()) return;
  note_failure(peer);
  core_.raise(Error(Code::rtps_authentication_timeout,
                    {.document = "the handshake with participant " + peer.name(),
                     .expected = "an end within 100 s",
                     .found = "no end",
                     .note = "the handshake continues; this is reported only once"}),
              peer, EventOrigin::anyone);
}

// DDS-Security 1.2, clause 9.8.3.1: a participant that could authenticate but fails to is matched
// like one that cannot. No single message counts as failure, because it can be sent in the peer's
// name. And a peer that does not accept the local certificate does not report it.
MonotonicTime Handshakes::next_admission(const Peer& peer) const {
  const auto* unproven = peer.state.unproven();
  if (unproven == nullptr || unproven->is_admitted) return kNever;
  const auto began = unproven->handshake->started_at();
  return began && admission_.admits_unauthenticated() ? *began + kAdmissionTimeout : kNever;
}

void Handshakes::admit_unauthenticated(Peer& peer) {
  if (!peer.state.on_admission_timeout()) return;
  const bool was_refused = peer.state.handshake()->refusals() > 0;
  core_.raise(Error(Code::rtps_admitted_unauthenticated,
                    {.document = "participant " + peer.name(),
                     .field = "allow_unauthenticated_participants",
                     .expected = "a handshake that succeeds within 3 s",
                     .found = was_refused ? "one whose messages were refused" : "none"}),
              peer, EventOrigin::anyone);
  core_.host.on_unauthenticated(GuidPrefix(peer.prefix()));
}

MonotonicTime Handshakes::next_of(const Peer& peer) const {
  const auto again = peer.state.is<peer::Refused>() ? peer.next_attempt_at : kNever;
  const auto* handshake = peer.state.handshake();
  if (handshake == nullptr) return again;
  return std::min({again, handshake->next_tick(), next_admission(peer), next_of_association(peer)});
}

}  // namespace ddssec::rtps
