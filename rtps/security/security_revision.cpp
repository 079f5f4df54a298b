// Security, the part that shuts out whoever lost its trust: new keys for all others (DDS-Security
// 1.2 9.8.10.4), in use once they have them.
#include <algorithm>

#include "rtps/security/security.hpp"

namespace ddssec::rtps {

void Security::distrust(const GuidPrefix& prefix) {
  drop_absent(prefix);
  auto* peer = find(prefix);
  if (peer == nullptr) return;
  peer->distrusted = true;
  if (peer->established) want_revision();
}

Status Security::revise_keys() {
  if (!revises()) return fail(Code::rtps_key_revision_disabled);
  want_revision();
  return {};
}

// One at a time. Who loses its trust meanwhile may have the keys that are on their way: then these
// are put to use for the others, and the next ones follow, for all that went until then.
void Security::tick_revision() {
  if (revision_ && (now_ >= revision_->deadline || all_have_revised())) finish_revision();
  if (!revision_ && revision_due_ && now_ >= revision_retry_) begin_revision();
}

MonotonicTime Security::next_revision() const {
  if (revision_) return all_have_revised() ? now_ : revision_->deadline;
  return revision_due_ ? std::max(now_, revision_retry_) : kNever;
}

void Security::begin_revision() {
  const auto number = keyring_.revise();
  if (!number) {
    events_.raise(Event(number.error()));
    revision_retry_ = now_ + kRevisionRetry;
    return;
  }
  revision_due_ = false;
  forget_absent();
  revision_ = {*number, now_ + kRevisionPatience};
  for (auto& [prefix, peer] : peers_)
    send_revised(peer);
}

void Security::send_revised(Peer& peer) {
  if (!is_trusted(peer)) return;
  const auto prefix = peer.data.guid.prefix;
  auto own = keyring_.participant_tokens(prefix, spi::KeyStage::revised);
  auto endpoints = keyring_.revised_tokens(prefix);
  if (!own || !endpoints) {
    const auto& error = own ? endpoints.error() : own.error();
    events_.raise(Event(error, {}, peer.data.guid.to_string()));
    return;
  }
  send_tokens(peer, message_class::kParticipantTokens, {}, {}, std::move(*own));
  for (auto& [local, remote, tokens] : *endpoints)
    send_endpoint_tokens(peer, local, remote, std::move(tokens));
}

void Security::send_revised(Peer& peer, const EntityId& local, const Guid& remote) {
  if (!is_trusted(peer)) return;
  auto tokens = keyring_.revised_tokens(local, remote);
  if (tokens) return send_endpoint_tokens(peer, local, remote, std::move(*tokens));
  events_.raise(Event(tokens.error(), {}, remote.to_string()));
}

bool Security::is_trusted(const Peer& peer) {
  return peer.volatile_writer && !peer.refused && !peer.distrusted;
}

bool Security::has_revised(const Peer& peer) const {
  return !is_trusted(peer) || peer.volatile_writer->all_acknowledged();
}

bool Security::all_have_revised() const {
  return std::ranges::all_of(peers_, [&](const auto& one) { return has_revised(one.second); });
}

void Security::finish_revision() {
  const auto status = keyring_.activate(revision_->number);
  const auto number = std::to_string(revision_->number);
  revision_.reset();
  if (!status) return events_.raise(Event(status.error()));
  events_.raise(Event(Error(Code::rtps_keys_revised, {.field = "key revision", .found = number})));
  for (const auto& [prefix, peer] : peers_)
    if (!has_revised(peer))
      events_.raise(Event(Error(Code::rtps_key_revision_unacknowledged, {.found = number}), {},
                          peer.data.guid.to_string()));
}

// ---- those who left

// Its identity and permissions stay with the plugins, which say when they end.
void Security::note_absent(Peer& peer) {
  if (!revises() || !is_trusted(peer)) return;
  if (absent_.size() >= kMostAbsent) return want_revision();
  absent_.push_back({peer.data.guid.prefix, std::move(peer.handshake),
                     std::exchange(peer.permissions, spi::PermissionsHandle{})});
}

void Security::give_back(Absent& absent) {
  absent.handshake.reset();
  if (absent.permissions)
    static_cast<void>(own_->plugins().access_control.return_permissions_handle(absent.permissions));
}

// Nobody watches it from here on, be it that it comes again: so what it knows shall not count.
void Security::drop_absent(const GuidPrefix& prefix) {
  const auto at = std::ranges::find(absent_, prefix, &Absent::prefix);
  if (at == absent_.end()) return;
  want_revision();
  give_back(*at);
  absent_.erase(at);
}

void Security::forget_absent() {
  for (auto& absent : absent_) give_back(absent);
  absent_.clear();
}

}  // namespace ddssec::rtps
