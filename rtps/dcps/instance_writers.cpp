#include "rtps/dcps/instance_writers.hpp"

namespace ddssec::rtps {

bool InstanceWriters::contains(const Guid& writer, InstanceHandle instance) const {
  const auto at = writers_.find(writer);
  return at != writers_.end() && at->second.instances.contains(instance);
}

bool InstanceWriters::has_room(const Guid& writer, InstanceHandle instance,
                               const HeldShareOf& share) const {
  const auto free = kMax - size_;
  if (free > 0 && (!share || share->joins < free)) return true;
  return contains(writer, instance);
}

bool InstanceWriters::add(const Guid& writer, InstanceHandle instance, const HeldShareOf& share) {
  auto& known = writers_[writer];
  if (known.instances.empty()) known.share = share;
  if (!known.instances.insert(instance).second) return false;
  ++size_;
  if (known.share) ++known.share->joins;
  return true;
}

bool InstanceWriters::remove(const Guid& writer, InstanceHandle instance) {
  const auto at = writers_.find(writer);
  if (at == writers_.end() || at->second.instances.erase(instance) == 0) return false;
  --size_;
  if (at->second.share) --at->second.share->joins;
  if (at->second.instances.empty()) writers_.erase(at);
  return true;
}

std::vector<InstanceHandle> InstanceWriters::instances_of(const Guid& writer) const {
  const auto at = writers_.find(writer);
  if (at == writers_.end()) return {};
  return {at->second.instances.begin(), at->second.instances.end()};
}

}  // namespace ddssec::rtps
