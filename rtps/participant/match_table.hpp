// The remote endpoints that matched one local endpoint.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "base/ids.hpp"

namespace ddssec::rtps {

/// Each entry includes the identity of the endpoint when it matched (ParticipantCore::identity_of),
/// and whether its announcement is proven: only its participant can have sent it.
class MatchTable {
 public:
  /// The largest number of endpoints of one identity.
  static constexpr std::size_t kMaxOfOne = 1024;

  bool contains(const Guid& remote) const { return matched_.contains(remote); }
  /// The limit for a local endpoint whose submessages carry a MAC for each match (DDS-Security 1.2,
  /// clause 10.5.3.3.4). With these MACs, a fragment, and the MACs of all participants, a datagram
  /// is full. One identity gets no more of the places than are free.
  static constexpr std::size_t kMaxWithMacs = 1900;

  /// `has_macs` means that its submessages carry a MAC for each match.
  bool has_room(const GuidPrefix& identity, bool has_macs = false) const {
    return fits(count(identity), matched_.size(), has_macs);
  }
  /// Returns the unproven endpoint of the identity that matched last. Empty if there is none, or if
  /// there is still no room without it.
  std::optional<Guid> replaceable(const GuidPrefix& identity, bool has_macs) const {
    const auto at = shares_.find(identity);
    if (at == shares_.end() || at->second.unproven.empty()) return std::nullopt;
    if (!fits(at->second.count - 1, matched_.size() - 1, has_macs)) return std::nullopt;
    return at->second.unproven.rbegin()->second;
  }
  void add(const Guid& remote, const GuidPrefix& identity, bool is_proven) {
    if (!matched_.try_emplace(remote, Entry{identity, ++last_}).second) return;
    auto& share = shares_[identity];
    ++share.count;
    if (!is_proven) share.unproven.emplace(last_, remote);
  }
  /// Returns false if the endpoint was not in the table.
  bool remove(const Guid& remote) {
    const auto at = matched_.find(remote);
    if (at == matched_.end()) return false;
    const auto share = shares_.find(at->second.identity);
    share->second.unproven.erase(at->second.number);
    if (--share->second.count == 0) shares_.erase(share);
    matched_.erase(at);
    return true;
  }
  std::vector<Guid> guids() const {
    std::vector<Guid> out;
    for (const auto& [guid, entry] : matched_) out.push_back(guid);
    return out;
  }

 private:
  struct Entry {
    GuidPrefix identity;
    std::uint64_t number;  ///< position in the order of matches
  };
  struct Share {
    std::size_t count = 0;
    std::map<std::uint64_t, Guid> unproven = {};  ///< by `number`
  };
  static bool fits(std::size_t own, std::size_t all, bool has_macs) {
    return own < kMaxOfOne && (!has_macs || (all < kMaxWithMacs && own < kMaxWithMacs - all));
  }
  std::size_t count(const GuidPrefix& identity) const {
    const auto at = shares_.find(identity);
    return at == shares_.end() ? 0 : at->second.count;
  }

  std::map<Guid, Entry> matched_;
  std::map<GuidPrefix, Share> shares_;
  std::uint64_t last_ = 0;
};

}  // namespace ddssec::rtps
