#include "rtps/security/key_reviser.hpp"

#include <algorithm>

namespace ddssec::rtps {

void KeyReviser::request(RevisionReason reason) {
  if (!is_enabled()) return;
  const auto by = reason == RevisionReason::trust_lost ? core_.now : core_.now + kMaxDelay;
  due_by_ = std::min(due_by_.value_or(kNever), by);
}

// A peer that loses its trust during a revision may have the keys that are being sent. These are
// still put to use, and another revision follows, which excludes all peers that lost trust until
// then.
void KeyReviser::tick() {
  if (under_way_ && (core_.now >= under_way_->deadline || all_are_up_to_date())) finish();
  if (!under_way_ && due_by_ && core_.now >= std::max(retry_, beginning())) begin();
}

MonotonicTime KeyReviser::next_tick() const {
  if (under_way_) return all_are_up_to_date() ? core_.now : under_way_->deadline;
  if (!due_by_) return kNever;
  return std::max({core_.now, retry_, beginning()});
}

MonotonicTime KeyReviser::beginning() const {
  return core_.governance_change.is_pending() ? *due_by_ : std::min(*due_by_, next_that_can_wait_);
}

void KeyReviser::begin() {
  const auto number = core_.keyring.revise();
  if (!number) {
    core_.events.raise(Event(number.error()));
    retry_ = core_.now + kRetry;
    return;
  }
  due_by_.reset();
  absent_.clear();
  // A dormant peer gets no new keys, so it cannot return. Each one flushes the messages that need
  // its keys.
  while (!core_.dormant.empty()) core_.dormant.erase(core_.dormant.begin());
  under_way_ = {*number, core_.now + kTimeout};
  next_that_can_wait_ = core_.now + kMinInterval;
  exchange_.set_revising(true);
  for (auto& [prefix, peer] : core_.peers) exchange_.send_revised(peer);
}

bool KeyReviser::all_are_up_to_date() const {
  return std::ranges::all_of(
      core_.peers, [](const auto& one) { return CryptoTokenExchange::is_up_to_date(one.second); });
}

void KeyReviser::finish() {
  const auto status = core_.keyring.activate(under_way_->number);
  const auto number = std::to_string(under_way_->number);
  under_way_.reset();
  exchange_.set_revising(false);
  if (!status) return core_.events.raise(Event(status.error()));
  core_.events.raise(
      Event(Error(Code::rtps_keys_revised, {.field = "key revision", .found = number})));
  for (const auto& [prefix, peer] : core_.peers)
    if (!CryptoTokenExchange::is_up_to_date(peer))
      core_.raise(Error(Code::rtps_key_revision_unacknowledged, {.found = number}), peer,
                  EventOrigin::its_keys);
}

void KeyReviser::poll_key_life() {
  if (!is_enabled()) return;
  if (core_.keyring.end_former_keys()) request();
}

// ---- participants that left

void KeyReviser::note_absent(Peer& peer) {
  if (!is_enabled() || !CryptoTokenExchange::is_trusted(peer)) return;
  if (absent_.size() >= kMaxAbsent) return request(RevisionReason::right_lost);
  auto& association = *peer.state.association();
  absent_.push_back({peer.prefix(), std::exchange(association.permissions, {}),
                     association.handshake->identity()});
}

std::shared_ptr<const PeerIdentity> KeyReviser::identity_of_absent(const GuidPrefix& prefix) const {
  if (const auto dormant = core_.dormant.find(prefix); dormant != core_.dormant.end())
    return dormant->second.peer.state.association()->handshake->identity();
  const auto at = std::ranges::find(absent_, prefix, &AbsentPeer::prefix);
  return at == absent_.end() ? nullptr : at->identity;
}

void KeyReviser::drop_absent(const GuidPrefix& prefix, RevisionReason reason) {
  if (std::erase_if(absent_, [&](const auto& absent) { return absent.prefix == prefix; }) > 0)
    request(reason);
}

}  // namespace ddssec::rtps
