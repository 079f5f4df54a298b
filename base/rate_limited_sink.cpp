#include "base/rate_limited_sink.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace ddssec {
namespace {

// True for an event that an attacker can cause at little cost.
bool names_an_unproven_peer(const Event& event) {
  const bool names_a_peer = !event.peer_subject.empty() || !event.guid.empty();
  return names_a_peer && event.proof == PeerProof::claimed;
}

// Returns a text that is the same for all participants of one certificate: the first six octets of
// an authenticated participant's GUID follow from the subject (DDS-Security 1.2, clause 10.3.3).
std::string certificate_of(const Event& event) {
  constexpr std::size_t kSubjectDigits = 12;
  return event.peer_subject.empty() ? event.guid.substr(0, kSubjectDigits) : event.peer_subject;
}

}  // namespace

void RateLimitedSink::raise(const Event& event) noexcept {
  try {
    pass_if_new(event);
  } catch (...) {
    // What the event reports has happened already, such as a refusal. It stands without the event.
  }
}

void RateLimitedSink::pass_if_new(const Event& event) {
  const auto& d = event.error.details();
  const auto code = std::to_string(static_cast<int>(event.error.code()));
  const bool is_claimed = names_an_unproven_peer(event);
  const bool is_proven = event.proof == PeerProof::authenticated;
  auto reason = fmt::format("{}\n{}\n{}", code, event.guid, d.document);
  if (!is_claimed) reason += fmt::format("\n{}\n{}\n{}", event.peer_subject, d.field, d.expected);
  // No peer chooses the text of a notice about the local participant, and each change of state is
  // new information.
  if (event.proof == PeerProof::not_a_peer && event.severity == Severity::informational)
    reason += "\n" + d.found;
  // Programs do not print an event that is also returned as an error. It must not use up the share
  // of an equal event that is only logged.
  if (event.is_returned) reason += "\nreturned";

  const std::lock_guard lock(mutex_);
  const auto now = clock_.monotonic();
  auto& share = is_claimed  ? claimed_
                : is_proven ? share_of(code + "\n" + certificate_of(event), now)
                            : ours_;
  const auto limit = is_claimed ? kMaxClaimed : is_proven ? kMaxOfAPeer : kMaxRemembered;
  if (has_room(share, limit, reason, now))
    pass_if_due(event, share, reason, now);
  else
    pass_if_due(event, crowded_out_, code + (is_claimed ? " claimed" : ""), now);
}

// Returns the share of a peer. If there are too many peers, all others use one common share that
// always counts as full.
RateLimitedSink::Times& RateLimitedSink::share_of(const std::string& peer,
                                                  std::chrono::nanoseconds now) {
  if (const auto known = proven_.find(peer); known != proven_.end()) return known->second;
  if (proven_.size() >= kMaxRemembered) {
    for (auto& [_, share] : proven_) forget_old(share, now);
    std::erase_if(proven_, [](const auto& entry) { return entry.second.empty(); });
  }
  return proven_.size() >= kMaxRemembered ? no_share_ : proven_[peer];
}

bool RateLimitedSink::has_room(Times& share, std::size_t limit, const std::string& reason,
                               std::chrono::nanoseconds now) const {
  if (&share == &no_share_) return false;
  if (share.contains(reason) || share.size() < limit) return true;
  forget_old(share, now);
  return share.size() < limit;
}

// An event that was lost must not suppress equal ones for the whole interval. Nor may each of them
// cost another call, because a sink that always throws, such as a full log, would have no limit.
void RateLimitedSink::pass_if_due(const Event& event, Times& share, const std::string& reason,
                                  std::chrono::nanoseconds now) {
  const auto [known, is_new] = share.try_emplace(reason, now);
  if (!is_new && now - known->second < interval_) return;
  known->second = now;
  try {
    next_.raise(event);
  } catch (...) {
    known->second = now - interval_ + std::min(interval_, kPauseAfterLoss);
  }
}

void RateLimitedSink::forget_old(Times& share, std::chrono::nanoseconds now) const {
  std::erase_if(share, [&](const auto& entry) { return now - entry.second >= interval_; });
}

}  // namespace ddssec
