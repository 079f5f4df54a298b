#include "rtps/participant/process_peers.hpp"

#include <algorithm>
#include <map>
#include <string>

#include "rtps/reliability/stateful_reader.hpp"
#include "wire/entity_ids.hpp"

namespace ddssec::rtps {

std::shared_ptr<ProcessPeers> ProcessPeers::of(DomainId domain, std::string_view tag) {
  static std::mutex mutex;
  static std::map<std::pair<DomainId, std::string>, std::weak_ptr<ProcessPeers>> all;
  const std::lock_guard lock(mutex);
  std::erase_if(all, [](const auto& entry) { return entry.second.expired(); });
  auto& known = all[{domain, std::string(tag)}];
  auto out = known.lock();
  if (!out) known = out = std::make_shared<ProcessPeers>();
  return out;
}

const ProcessPeer* ProcessPeers::find(const GuidPrefix& prefix) const {
  const auto at =
      std::ranges::find_if(members_, [&](const auto* p) { return p->prefix() == prefix; });
  return at == members_.end() ? nullptr : *at;
}

// Endpoints with protection always use the network, where the other side proves its identity.
const ProcessPeer* process_peer_of(const ProcessPeer& own, const ProcessPeers* others,
                                   const EntityId& local, const Guid& remote) {
  if (remote.prefix == own.prefix()) return &own;
  const auto* other = others != nullptr ? others->find(remote.prefix) : nullptr;
  const bool open = other != nullptr && own.is_secured() == other->is_secured() &&
                    own.is_unprotected(local) && other->is_unprotected(remote.entity);
  return open ? other : nullptr;
}

void join_in_process(const ProcessPeer& own, const ProcessPeer& other, const Guid& local,
                     const Guid& remote) {
  const bool writes = is_writer(local.entity);
  auto* writer = writes ? own.writer(local) : other.writer(remote);
  auto* reader = writes ? other.reader(remote) : own.reader(local);
  if (writer != nullptr && reader != nullptr) writer->attach(*reader);
}

}  // namespace ddssec::rtps
