// Counts how much of a store the samples of each identity use. No identity may use more octets of
// the store than are free, and no more places of a stream than are free in it. So there is always
// room for another identity.
#pragma once

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "base/ids.hpp"
#include "rtps/reliability/change.hpp"

namespace ddssec::rtps {

/// Counts the octets of one store by identity.
class StoreShares {
 public:
  /// Identifies a share; kNone has no limit.
  using Account = std::uint32_t;
  static constexpr Account kNone = 0;

  /// Returns the approximate number of octets that a sample uses in the file. Small samples share a
  /// page.
  static std::size_t cost(std::size_t payload) {
    constexpr std::size_t kRest = 160, kPage = 4096;
    const auto octets = payload + kRest;
    return octets <= kPage / 2 ? octets : (octets + kPage - 1) / kPage * kPage;
  }

  /// Returns the share of an identity (ParticipantCore::identity_of).
  Account account(const GuidPrefix& identity);
  std::size_t octets(Account account) const { return shares_[account].octets; }
  void add(Account account, std::size_t octets) { shares_[account].octets += octets; }
  void remove(Account account, std::size_t octets) {
    auto& own = shares_[account].octets;
    own -= std::min(own, octets);
  }

  struct Refusals {
    GuidPrefix identity;
    std::uint64_t times;  ///< total so far
  };
  /// Counts a sample that had no room.
  void refuse(const GuidPrefix& identity);
  /// Returns the identities whose refusals have doubled since the last report.
  std::vector<Refusals> take_unreported() { return std::exchange(unreported_, {}); }
  bool has_unreported() const { return !unreported_.empty(); }

 private:
  struct Share {
    GuidPrefix identity;
    std::size_t octets = 0;
    std::uint64_t refused = 0;
  };
  std::vector<Share> shares_{1};
  std::map<GuidPrefix, Account> accounts_;
  std::vector<Refusals> unreported_;
};

}  // namespace ddssec::rtps
