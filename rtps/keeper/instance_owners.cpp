#include "rtps/keeper/instance_owners.hpp"

namespace ddssec::rtps {

void InstanceOwners::set_writer(const Guid& writer, std::int32_t strength,
                                const std::optional<GuidPrefix>& identity) {
  const auto [at, is_new] = writers_.try_emplace(writer, strength, identity);
  at->second.strength = strength;  // its identity does not change while it is matched
  if (!is_new || !identity) return;
  // Instances that the writer was only expected to own count for its identity from now on.
  for (auto owned = owned_.lower_bound({writer, {}});
       owned != owned_.end() && owned->first == writer; ++owned)
    ++of_identity_[*identity];
}

void InstanceOwners::remove_writer(const Guid& writer) {
  note_lease_ended(writer);
  writers_.erase(writer);
}

void InstanceOwners::note_lease_ended(const Guid& writer) {
  for (auto at = owned_.lower_bound({writer, {}}); at != owned_.end() && at->first == writer;)
    leave(owners_.find((at++)->second));
}

void InstanceOwners::expect(const KeyHash& instance, const Guid& writer) {
  if (const auto known = owners_.find(instance); known != owners_.end()) leave(known);
  if (owners_.size() < kMaxInstances / 2) enter(instance, writer);
}

bool InstanceOwners::is_stronger(const Guid& writer, const Guid& owner) const {
  const auto ours = writers_.find(writer), theirs = writers_.find(owner);
  if (ours == writers_.end() || theirs == writers_.end()) return theirs == writers_.end();
  const auto own = ours->second.strength, other = theirs->second.strength;
  return own > other || (own == other && writer < owner);
}

std::optional<GuidPrefix> InstanceOwners::identity_of(const Guid& writer) const {
  const auto known = writers_.find(writer);
  return known == writers_.end() ? std::nullopt : known->second.identity;
}

bool InstanceOwners::has_room(const Guid& writer, const Guid* replaced) const {
  const auto free = kMaxInstances - owners_.size() + (replaced == nullptr ? 0 : 1);
  const auto identity = identity_of(writer);
  const auto own = identity ? of_identity_.find(*identity) : of_identity_.end();
  if (free == 0 || own == of_identity_.end()) return free > 0;
  const bool replaces_own = replaced != nullptr && identity_of(*replaced) == identity;
  return own->second - (replaces_own ? 1 : 0) < free;
}

InstanceOwners::Claim InstanceOwners::claim(const KeyHash& instance, const Guid& writer,
                                            MonotonicTime now) {
  const auto at = owners_.find(instance);
  if (at == owners_.end()) {
    if (!has_room(writer)) return Claim::no_room;
    enter(instance, writer);
    return Claim::owned;
  }
  if (at->second == writer) return Claim::owned;
  if (!writers_.contains(at->second) && now < expects_until_) return Claim::later;
  if (!is_stronger(writer, at->second)) return Claim::refused;
  if (!has_room(writer, &at->second)) return Claim::no_room;
  leave(at);
  enter(instance, writer);
  return Claim::owned;
}

void InstanceOwners::release(const KeyHash& instance, const Guid& writer) {
  const auto at = owners_.find(instance);
  if (at != owners_.end() && at->second == writer) leave(at);
}

void InstanceOwners::enter(const KeyHash& instance, const Guid& writer) {
  owners_.emplace(instance, writer);
  owned_.emplace(writer, instance);
  if (const auto identity = identity_of(writer)) ++of_identity_[*identity];
}

void InstanceOwners::leave(Owners::iterator at) {
  if (const auto identity = identity_of(at->second))
    if (const auto own = of_identity_.find(*identity); --own->second == 0) of_identity_.erase(own);
  owned_.erase({at->second, at->first});
  owners_.erase(at);
}

}  // namespace ddssec::rtps
