// Participants of one process that need no network between them.
#pragma once

#include <memory>
#include <mutex>
#include <string_view>
#include <vector>

#include "base/ids.hpp"

namespace ddssec::rtps {

class StatefulReader;
class StatefulWriter;

/// A participant's endpoints, as the other participants of its process see them.
class Neighbour {
 public:
  virtual ~Neighbour() = default;
  virtual const GuidPrefix& prefix() const = 0;
  virtual bool is_secured() const = 0;
  /// Nothing that the endpoint says is protected.
  virtual bool is_open(const EntityId& endpoint) const = 0;
  // nullptr: not one of its endpoints.
  virtual StatefulWriter* writer(const Guid& guid) const = 0;
  virtual StatefulReader* reader(const Guid& guid) const = 0;
};

/// The participants of this process in one domain with one tag. They share one lock, under which
/// each may call the others' endpoints.
class Neighbourhood {
 public:
  /// That of the domain, or a new one.
  static std::shared_ptr<Neighbourhood> of(DomainId domain, std::string_view tag);

  std::mutex& mutex() { return mutex_; }

  // With the lock held:
  void enter(const Neighbour& member) { members_.push_back(&member); }
  void leave(const Neighbour& member) { std::erase(members_, &member); }
  /// nullptr: none of them.
  const Neighbour* find(const GuidPrefix& prefix) const;

 private:
  std::mutex mutex_;
  std::vector<const Neighbour*> members_;
};

/// The participant of this process, `own` included, whose endpoint may be called directly by the
/// local one; nullptr: the pair goes by the wire. Both sides of a pair get the same answer.
const Neighbour* neighbour_of(const Neighbour& own, const Neighbourhood* others,
                              const EntityId& local, const Guid& remote);
/// From now on the writer of the pair feeds its reader directly, once both sides have matched.
void join_in_process(const Neighbour& own, const Neighbour& other, const Guid& local,
                     const Guid& remote);

}  // namespace ddssec::rtps
