#include "rtps/security/protection_phases.hpp"

namespace ddssec::rtps {

void ProtectionPhases::swap() noexcept {
  endpoints_.swap();
  messages_.swap();
  has_swapped_ = true;
}

void ProtectionPhases::remove_second() {
  endpoints_.remove_all();
  messages_.remove_second();
  has_swapped_ = false;
  for (auto& [prefix, remote] : remotes_) {
    remote.sends_next = remote.says_next = false;
    // The same protection has other keys when it comes again, and that is no revision.
    std::erase_if(remote.keys, [&](const auto& keys) { return keys.first != messages_.id(); });
  }
}

void ProtectionPhases::note_sends_next(const GuidPrefix& peer) {
  const auto at = remotes_.find(peer);
  if (at != remotes_.end()) at->second.sends_next = at->second.says_next = true;
}

bool ProtectionPhases::counts_second(const GuidPrefix& peer) const {
  const auto at = remotes_.find(peer);
  return at != remotes_.end() && at->second.sends_next != has_swapped_;
}

const LocalKeys* ProtectionPhases::only_next(const EntityId& id, const Guid& remote) const {
  const auto* second = endpoints_.second_keys_of(id, remote);
  if (second == nullptr) [[likely]]
    return nullptr;
  const auto at = remotes_.find(remote.prefix);
  if (at == remotes_.end() || !at->second.says_next) return nullptr;
  return has_swapped_ ? find(locals_, id) : second;
}

bool ProtectionPhases::is_former(const EntityId& id, const Guid& remote,
                                 ProtectionId protection) const {
  const auto* next = only_next(id, remote);
  return next != nullptr && next->protection != protection;
}

bool ProtectionPhases::must_protect_messages(const GuidPrefix& peer) const {
  return is_protected(counts_second(peer) ? messages_.second_kind() : messages_.kind());
}

Sha256Digest ProtectionPhases::message_keys_of(const GuidPrefix& peer) const {
  const auto at = remotes_.find(peer);
  if (at == remotes_.end()) return {};
  const auto& keys = at->second.keys;
  const auto kind = counts_second(peer) ? messages_.second_kind() : messages_.kind();
  const auto found = keys.find(MessageKeys::id_of(kind));
  return found == keys.end() ? Sha256Digest{} : found->second;
}

const LocalKeys* ProtectionPhases::demanded(const EntityId& id, const Guid& remote) const {
  if (counts_second(remote.prefix))
    if (const auto* second = endpoints_.second_keys_of(id, remote)) return second;
  return find(locals_, id);
}

}  // namespace ddssec::rtps
