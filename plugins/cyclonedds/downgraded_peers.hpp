// Remote participants that the host has just begun to count as unauthenticated.
//
// The core has one security state of a remote participant for all local ones. If authentication
// answers with an error for a local participant whose governance admits unauthenticated
// participants, the core removes that state. It then stores a later answer that is no error, for
// another local participant, through a null pointer. So after such an error every local participant
// of the process must get one.
#pragma once

#include <chrono>
#include <map>
#include <mutex>

#include "base/ids.hpp"

namespace ddssec::cyclonedds {

/// The peers, each for a short time. Thread-safe.
class DowngradedPeers {
 public:
  /// The core asks for all local participants as soon as it has discovered a peer. Later it may
  /// have discovered the peer again, with a new state.
  static constexpr std::chrono::seconds kTime{10};
  /// Beyond that, the oldest entry is removed.
  static constexpr std::size_t kMaxPeers = 1024;

  void note(const Guid& peer, std::chrono::nanoseconds now);
  bool contains(const Guid& peer, std::chrono::nanoseconds now) const;

 private:
  mutable std::mutex mutex_;
  std::map<Guid, std::chrono::nanoseconds> since_;
};

}  // namespace ddssec::cyclonedds
