// Participants of one process, which need no network between them.
#pragma once

#include <memory>
#include <mutex>
#include <string_view>
#include <vector>

#include "base/ids.hpp"

namespace ddssec::rtps {

class StatefulReader;
class StatefulWriter;

/// A participant's endpoints, as used by the other participants of its process.
class ProcessPeer {
 public:
  virtual ~ProcessPeer() = default;
  virtual const GuidPrefix& prefix() const = 0;
  virtual bool is_secured() const = 0;
  /// True if nothing that the endpoint sends is protected.
  virtual bool is_unprotected(const EntityId& endpoint) const = 0;
  // Both return nullptr if it is not one of the participant's endpoints.
  virtual StatefulWriter* writer(const Guid& guid) const = 0;
  virtual StatefulReader* reader(const Guid& guid) const = 0;
};

/// The participants of this process in one domain with one domain tag. They share one lock. A
/// participant that holds it may call the endpoints of the others.
class ProcessPeers {
 public:
  /// Returns the participants of the domain and tag, or a new object if there are none.
  static std::shared_ptr<ProcessPeers> of(DomainId domain, std::string_view tag);

  std::mutex& mutex() { return mutex_; }

  // The caller holds the lock:
  void enter(const ProcessPeer& member) { members_.push_back(&member); }
  void leave(const ProcessPeer& member) { std::erase(members_, &member); }
  /// Returns nullptr if there is no such participant.
  const ProcessPeer* find(const GuidPrefix& prefix) const;

 private:
  std::mutex mutex_;
  std::vector<const ProcessPeer*> members_;
};

/// Returns the participant of this process, possibly `own`, whose endpoint the local endpoint may
/// call directly. nullptr means that the pair uses the network. Both sides of a pair get the same
/// answer.
const ProcessPeer* process_peer_of(const ProcessPeer& own, const ProcessPeers* others,
                                   const EntityId& local, const Guid& remote);
/// Makes the writer of the pair pass changes directly to its reader, once both sides have matched.
void join_in_process(const ProcessPeer& own, const ProcessPeer& other, const Guid& local,
                     const Guid& remote);

}  // namespace ddssec::rtps
