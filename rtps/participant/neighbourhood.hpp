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
class Neighbour {
 public:
  virtual ~Neighbour() = default;
  virtual const GuidPrefix& prefix() const = 0;
  virtual bool is_secured() const = 0;
  /// True if nothing that the endpoint sends is protected.
  virtual bool is_open(const EntityId& endpoint) const = 0;
  // Return nullptr if it is not one of its endpoints.
  virtual StatefulWriter* writer(const Guid& guid) const = 0;
  virtual StatefulReader* reader(const Guid& guid) const = 0;
};

/// The participants of this process in one domain with one domain tag. They share one lock. A
/// participant that holds it may call the endpoints of the others.
class Neighbourhood {
 public:
  /// Returns the neighbourhood of the domain, or a new one.
  static std::shared_ptr<Neighbourhood> of(DomainId domain, std::string_view tag);

  std::mutex& mutex() { return mutex_; }

  // The caller holds the lock:
  void enter(const Neighbour& member) { members_.push_back(&member); }
  void leave(const Neighbour& member) { std::erase(members_, &member); }
  /// Returns nullptr if there is no such participant.
  const Neighbour* find(const GuidPrefix& prefix) const;

 private:
  std::mutex mutex_;
  std::vector<const Neighbour*> members_;
};

/// Returns the participant of this process, `own` included, whose endpoint the local endpoint may
/// call directly. nullptr: the pair uses the network. Both sides of a pair get the same answer.
const Neighbour* neighbour_of(const Neighbour& own, const Neighbourhood* others,
                              const EntityId& local, const Guid& remote);
/// From now on the writer of the pair passes changes directly to its reader, once both sides have
/// matched.
void join_in_process(const Neighbour& own, const Neighbour& other, const Guid& local,
                     const Guid& remote);

}  // namespace ddssec::rtps
