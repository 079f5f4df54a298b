#include "rtps/security/second_protections.hpp"

#include <algorithm>

namespace ddssec::rtps {

Status SecondProtections::add(const EntityId& id,
                              const spi::EndpointSecurityAttributes& attributes) {
  const auto* first = rtps::find(first_, id);
  if (first == nullptr) return fail(Code::crypto_not_matched);
  LocalKeys local{attributes};
  local.properties = first->properties;
  keys_.remove(others_, id);
  return keys_.add(others_, id, std::move(local));
}

const spi::EndpointSecurityAttributes* SecondProtections::attributes(const EntityId& id) const {
  const auto* other = rtps::find(others_, id);
  return other == nullptr ? nullptr : &other->attributes;
}

void SecondProtections::swap() noexcept {
  for (auto& [id, other] : others_)
    if (const auto at = first_.find(id); at != first_.end()) std::swap(at->second, other);
}

void SecondProtections::set_permitted(const EntityId& id, const Guid& remote, bool may) {
  if (may)
    permitted_[id].insert(remote);
  else
    forget(permitted_, id, remote);
}

// The builtin endpoints of all peers that are authenticated are matched.
bool SecondProtections::is_permitted(const EntityId& id, const Guid& remote) const {
  const auto* first = rtps::find(first_, id);
  if (first != nullptr && first->attributes.is_builtin) return true;
  const auto of = permitted_.find(id);
  return of != permitted_.end() && of->second.contains(remote);
}

void SecondProtections::note_announced(const EntityId& id, const Guid& remote, bool with_second) {
  if (with_second)
    announced_with_second_[id].insert(remote);
  else
    forget(announced_with_second_, id, remote);
}

bool SecondProtections::any_announced_with_second(const GuidPrefix& prefix) const {
  return std::ranges::any_of(announced_with_second_, [&](const auto& of) {
    const auto at = of.second.lower_bound({prefix, {}});
    return at != of.second.end() && at->prefix == prefix;
  });
}

void SecondProtections::forget(Pairs& from, const EntityId& id, const Guid& remote) {
  if (const auto of = from.find(id); of != from.end()) of->second.erase(remote);
}

void SecondProtections::remove(const EntityId& id) {
  permitted_.erase(id);
  announced_with_second_.erase(id);
  keys_.remove(others_, id);
}

// If the pair returns, it is judged again whether it may have these keys.
void SecondProtections::unregister_pair(const EntityId& id, const Guid& remote, AfterMatch after) {
  forget(permitted_, id, remote);
  forget(announced_with_second_, id, remote);
  if (const auto displaced = keys_.unregister_pair(others_, id, remote, after))
    unregister_pair(id, *displaced);
}

bool SecondProtections::resume(const EntityId& id, const Guid& remote, bool is_relay_only) {
  const auto other = others_.find(id);
  if (other == others_.end()) return false;
  auto& local = other->second;
  const auto pair = local.pairs.find(remote);
  if (pair == local.pairs.end() || (!pair->second.is_suspended && !pair->second.is_silent))
    return false;
  if (pair->second.is_relay_only != is_relay_only || !is_permitted(id, remote)) {
    unregister_pair(id, remote);
    return false;
  }
  keys_.resume(id, local, remote, pair->second);
  pair->second.is_unsent = true;
  const bool are_doubtful = pair->second.are_keys_doubtful;
  if (const auto displaced = local.note_idle(remote, pair->second)) unregister_pair(id, *displaced);
  return are_doubtful;
}

void SecondProtections::drop_keys(const EntityId& id, const std::optional<Guid>& remote) {
  if (!remote) return;
  unregister_pair(id, *remote);
  keys_.unregister_pair(first_, id, *remote, AfterMatch::gone);
}

void SecondProtections::unregister_pairs_of(const GuidPrefix& remote) {
  for (auto* pairs : {&permitted_, &announced_with_second_})
    for (auto& [id, guids] : *pairs)
      std::erase_if(guids, [&](const Guid& guid) { return guid.prefix == remote; });
  keys_.unregister_pairs_of(others_, remote);
}

void SecondProtections::remove_all() {
  permitted_.clear();
  announced_with_second_.clear();
  while (!others_.empty()) remove(EntityId(others_.begin()->first));
}

ProtectionId SecondProtections::first_protection_of(const EntityId& id) const {
  const auto* local = rtps::find(first_, id);
  return local == nullptr ? 0 : local->protection;
}

bool SecondProtections::knows(const EntityId& id, ProtectionId protection) const {
  const auto* other = rtps::find(others_, id);
  return first_protection_of(id) == protection ||
         (other != nullptr && other->protection == protection);
}

bool SecondProtections::has_pair_under_two_protections(const GuidPrefix& prefix) const {
  const auto has_pair = [&](const LocalKeys* local) {
    if (local == nullptr) return false;
    const auto at = local->pairs.lower_bound({prefix, {}});
    return at != local->pairs.end() && at->first.prefix == prefix;
  };
  return std::ranges::any_of(others_, [&](const auto& one) {
    return has_pair(&one.second) || has_pair(rtps::find(first_, one.first));
  });
}

void SecondProtections::send_again(const GuidPrefix& prefix) {
  for (auto& [id, other] : others_)
    for (auto at = other.pairs.lower_bound({prefix, {}});
         at != other.pairs.end() && at->first.prefix == prefix; ++at)
      at->second.is_unsent = at->second.handle != 0;
}

void SecondProtections::send_again(const EntityId& id, const Guid& remote) {
  const auto other = others_.find(id);
  if (other == others_.end()) return;
  const auto pair = other->second.pairs.find(remote);
  if (pair != other->second.pairs.end()) pair->second.is_unsent = pair->second.handle != 0;
}

std::vector<std::pair<EntityId, Guid>> SecondProtections::incomplete_pairs(
    const GuidPrefix& prefix) const {
  std::vector<std::pair<EntityId, Guid>> out;
  const auto add = [&](const EntityId& id, const LocalKeys& has, const LocalKeys& lacks) {
    for (auto at = has.pairs.lower_bound({prefix, {}});
         at != has.pairs.end() && at->first.prefix == prefix; ++at)
      if (!at->second.is_suspended && (at->second.is_unsent || !lacks.pairs.contains(at->first)) &&
          is_permitted(id, at->first))
        out.emplace_back(id, at->first);
  };
  for (const auto& [id, other] : others_)
    if (const auto* first = rtps::find(first_, id)) {
      add(id, *first, other);
      add(id, other, *first);
    }
  return out;
}

Result<SecondProtections::Completion> SecondProtections::complete(const EntityId& id,
                                                                  const Guid& remote) {
  const auto first = first_.find(id), other = others_.find(id);
  if (first == first_.end() || other == others_.end() || !is_permitted(id, remote))
    return Completion{};
  const auto in_first = first->second.pairs.find(remote);
  const auto in_other = other->second.pairs.find(remote);
  const bool has_first = in_first != first->second.pairs.end();
  const bool has_other = in_other != other->second.pairs.end();
  if (has_first && in_first->second.is_suspended) return Completion{};
  if (has_other && std::exchange(in_other->second.is_unsent, false)) {
    DDSSEC_ASSIGN_OR_RETURN(auto tokens, keys_.tokens_for(id, other->second, in_other->second));
    return Completion{other->second.protection, std::move(tokens)};
  }
  if (has_first == has_other) return Completion{};
  auto& lacks = has_first ? other->second : first->second;
  const bool is_relay_only =
      has_first ? in_first->second.is_relay_only : in_other->second.is_relay_only;
  DDSSEC_ASSIGN_OR_RETURN(auto registered, keys_.register_pair(id, lacks, remote, is_relay_only));
  // A pair keeps its first protection without the second one, but not the other way round.
  if (has_other)
    drop_keys(id, registered.displaced);
  else if (registered.displaced)
    unregister_pair(id, *registered.displaced);
  return Completion{lacks.protection, std::move(registered.tokens)};
}

Result<SecondProtections::Completion> SecondProtections::revised_tokens(const EntityId& id,
                                                                        const Guid& remote) {
  const auto other = others_.find(id);
  if (other == others_.end() || !is_permitted(id, remote)) return Completion{};
  const auto pair = other->second.pairs.find(remote);
  if (pair == other->second.pairs.end() || pair->second.handle == 0 || pair->second.is_suspended)
    return Completion{};
  DDSSEC_ASSIGN_OR_RETURN(
      auto tokens, keys_.tokens_for(id, other->second, pair->second, spi::KeyStage::revised));
  return Completion{other->second.protection, std::move(tokens)};
}

void SecondProtections::add_pairs_with_keys(const GuidPrefix& prefix,
                                            std::set<std::pair<EntityId, Guid>>& to) const {
  for (const auto& [id, other] : others_)
    for (auto at = other.pairs.lower_bound({prefix, {}});
         at != other.pairs.end() && at->first.prefix == prefix; ++at)
      if (at->second.handle != 0 && !at->second.is_suspended) to.emplace(id, at->first);
}

const LocalKeys* SecondProtections::second_keys_of(const EntityId& id, const Guid& remote) const {
  if (others_.empty()) [[likely]]
    return nullptr;
  const auto* other = rtps::find(others_, id);
  return other != nullptr && other->pairs.contains(remote) ? other : nullptr;
}

LocalKeys* SecondProtections::find(const EntityId& id, ProtectionId protection) {
  const auto first = first_.find(id);
  if (first != first_.end() && (protection == 0 || first->second.protection == protection))
    return &first->second;
  const auto at = others_.find(id);
  return at != others_.end() && at->second.protection == protection ? &at->second : nullptr;
}

}  // namespace ddssec::rtps
