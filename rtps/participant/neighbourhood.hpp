// Participants of one process that need no network between them.
#pragma once

#include <memory>
#include <mutex>
#include <string_view>
#include <vector>

#include "base/ids.hpp"

namespace ddssec::rtps {

class Participant;

/// The participants of this process in one domain with one tag. They share one lock, under which
/// each may call the others' endpoints.
class Neighbourhood {
 public:
  /// That of the domain, or a new one.
  static std::shared_ptr<Neighbourhood> of(DomainId domain, std::string_view tag);

  std::mutex& mutex() { return mutex_; }

  // With the lock held:
  void enter(Participant& participant) { members_.push_back(&participant); }
  void leave(Participant& participant) { std::erase(members_, &participant); }
  /// nullptr: none of them.
  Participant* find(const GuidPrefix& prefix) const;

 private:
  std::mutex mutex_;
  std::vector<Participant*> members_;
};

}  // namespace ddssec::rtps
