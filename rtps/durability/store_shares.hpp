// How much of a store the samples of each identity use. No identity may use more octets of the
// store than are free, and no more places of a stream than are free in it. So there is always room
// for another identity.
#pragma once

#include <map>
#include <set>
#include <utility>
#include <vector>

#include "base/ids.hpp"
#include "rtps/reliability/change.hpp"

namespace ddssec::rtps {

class StoreShares {
 public:
  /// Identifies a share; kNone has no limit.
  using Account = std::uint32_t;
  static constexpr Account kNone = 0;

  /// The approximate number of octets that a sample uses in the file.
  static std::size_t cost(std::size_t payload) { return payload + 160; }

  /// `identity`: see ParticipantCore::identity_of.
  Account account(const GuidPrefix& identity);
  const GuidPrefix& identity(Account account) const { return shares_[account].identity; }
  std::size_t octets(Account account) const { return shares_[account].octets; }
  void add(Account account, std::size_t octets) { shares_[account].octets += octets; }
  void remove(Account account, std::size_t octets) { shares_[account].octets -= octets; }
  /// Sets all shares to 0. The accounts stay valid.
  void clear();

  struct Refusals {
    GuidPrefix identity;
    std::uint64_t samples;  ///< total so far
  };
  /// A change that does not fit a share.
  struct Refused {
    std::int64_t stream;
    KeyHash instance;
    std::size_t octets;
  };
  /// From now on the account is crowded.
  void refuse(Account account, const Refused& change);
  /// How often changes were refused; never reset.
  std::uint64_t refused() const { return refused_; }
  /// True if an earlier change of this instance was refused, so that this one must come later.
  bool is_behind(Account account, std::int64_t stream, const KeyHash& instance) const;
  /// The identities whose accounts are crowded.
  std::set<GuidPrefix> crowded() const;
  /// Ends that for the accounts whose first refused change fits now.
  template <class Fits>
  void look_again(Fits fits) {
    std::erase_if(crowds_,
                  [&](const auto& crowd) { return fits(crowd.first, crowd.second.first); });
  }
  /// The identities whose refusals have doubled since the last report.
  std::vector<Refusals> take_news() { return std::exchange(news_, {}); }

 private:
  struct Share {
    GuidPrefix identity;
    std::size_t octets = 0;
    std::uint64_t refused = 0;
  };
  std::vector<Share> shares_{1};
  std::map<GuidPrefix, Account> accounts_;
  std::vector<Refusals> news_;
  struct Crowd {
    Refused first;
    std::set<std::pair<std::int64_t, KeyHash>> instances;
  };
  std::map<Account, Crowd> crowds_;
  std::uint64_t refused_ = 0;
};

}  // namespace ddssec::rtps
