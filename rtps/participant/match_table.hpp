// The remote endpoints that matched one local endpoint.
#pragma once

#include <map>
#include <vector>

#include "base/ids.hpp"

namespace ddssec::rtps {

/// Each entry includes the identity that the endpoint belonged to when it matched
/// (ParticipantCore::identity_of).
class MatchTable {
 public:
  /// Limit for the endpoints of one identity.
  static constexpr std::size_t kMaxOfOne = 1024;

  bool contains(const Guid& remote) const { return matched_.contains(remote); }
  /// The limits for a local endpoint whose submessages carry a MAC for each match
  /// (DDS-Security 1.2, clause 10.5.3.3.4). With them, a fragment and the MACs of all participants,
  /// a datagram is full. One identity gets no more of the places than are free.
  static constexpr std::size_t kMaxWithMacs = 1900;

  /// `has_macs`: its submessages carry a MAC for each match.
  bool has_room(const GuidPrefix& identity, bool has_macs = false) const {
    const auto known = counts_.find(identity);
    const auto own = known == counts_.end() ? 0 : known->second;
    if (own >= kMaxOfOne) return false;
    return !has_macs || (matched_.size() < kMaxWithMacs && own < kMaxWithMacs - matched_.size());
  }
  void add(const Guid& remote, const GuidPrefix& identity) {
    if (matched_.try_emplace(remote, identity).second) ++counts_[identity];
  }
  /// Returns false if the endpoint was not in the table.
  bool remove(const Guid& remote) {
    const auto at = matched_.find(remote);
    if (at == matched_.end()) return false;
    const auto count = counts_.find(at->second);
    if (--count->second == 0) counts_.erase(count);
    matched_.erase(at);
    return true;
  }
  std::vector<Guid> guids() const {
    std::vector<Guid> out;
    for (const auto& [guid, identity] : matched_) out.push_back(guid);
    return out;
  }

 private:
  std::map<Guid, GuidPrefix> matched_;
  std::map<GuidPrefix, std::size_t> counts_;
};

}  // namespace ddssec::rtps
