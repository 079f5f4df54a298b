// The remote endpoints that did not match one local endpoint because their identity had no place
// left.
#pragma once

#include <array>
#include <concepts>
#include <list>
#include <map>
#include <optional>

#include "rtps/participant/match_table.hpp"

namespace ddssec::rtps {

/// Waiting endpoints wait until a match ends (MatchTable). Among those of one identity, proven ones
/// come first, and otherwise the one that has waited longest. Identities take turns.
class WaitingMatches {
 public:
  /// The largest number of waiting endpoints of one identity: of those that are proven, and of all
  /// others.
  static constexpr std::size_t kMaxOfOne = MatchTable::kMaxOfOne;

  bool empty() const { return places_.empty(); }
  /// Adds an endpoint. `is_proven` means that only its participant can have announced it. Has no
  /// effect if it waits already, or if there is no room: then it is not tried again until it is
  /// announced again.
  void add(const Guid& remote, const GuidPrefix& identity, bool is_proven) {
    if (places_.contains(remote)) return;
    auto& queue = queues_[identity][is_proven ? 0 : 1];
    if (queue.size() >= kMaxOfOne) return;
    queue.push_back(remote);
    places_[remote] = {identity, is_proven, std::prev(queue.end())};
  }
  /// Removes an endpoint that has ended, or may not match.
  void remove(const Guid& remote) {
    const auto at = places_.find(remote);
    if (at == places_.end()) return;
    const auto& [identity, is_proven, place] = at->second;
    const auto queues = queues_.find(identity);
    queues->second[is_proven ? 0 : 1].erase(place);
    if (queues->second[0].empty() && queues->second[1].empty()) queues_.erase(queues);
    places_.erase(at);
  }
  /// Removes and returns the next endpoint of an identity that has room; empty if there is none.
  std::optional<Guid> take(std::predicate<const GuidPrefix&> auto has_room) {
    auto at = queues_.upper_bound(served_);
    for (auto left = queues_.size(); left > 0; --left, ++at) {
      if (at == queues_.end()) at = queues_.begin();
      if (!has_room(at->first)) continue;
      served_ = at->first;
      const auto& [proven, others] = at->second;
      const auto next = proven.empty() ? others.front() : proven.front();
      remove(next);
      return next;
    }
    return std::nullopt;
  }

 private:
  using Queue = std::list<Guid>;
  struct Place {
    GuidPrefix identity;
    bool is_proven = false;
    Queue::iterator at = {};
  };
  std::map<GuidPrefix, std::array<Queue, 2>> queues_;  ///< the first queue has the proven ones
  std::map<Guid, Place> places_;
  GuidPrefix served_{};  ///< the identity that had the last turn
};

}  // namespace ddssec::rtps
