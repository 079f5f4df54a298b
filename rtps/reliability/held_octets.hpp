// The octets that a reader holds out of order, counted by the identity that sent them.
#pragma once

#include <cstddef>
#include <map>
#include <optional>

#include "base/ids.hpp"

namespace ddssec::rtps {

/// Each identity has a share. So an attacker that spreads its data over many writers of its own
/// takes no room from others.
class HeldOctets {
  struct Share {
    std::size_t writers = 0, octets = 0;
  };

 public:
  static constexpr std::size_t kMax = std::size_t{256} << 20;
  static constexpr std::size_t kMaxOfOne = kMax / 2;
  struct Limits {
    std::size_t all = kMax;
    std::size_t of_one = kMaxOfOne;  ///< for all writers of one identity
  };

  /// The part of its identity's share that one writer uses, until it is destroyed.
  class Account {
   public:
    /// `all` must outlive this account.
    Account(HeldOctets& all, const GuidPrefix& identity);
    ~Account();
    Account(const Account&) = delete;
    Account& operator=(const Account&) = delete;

    void hold(std::size_t octets);
    void release(std::size_t octets);
    std::size_t octets() const { return octets_; }
    const GuidPrefix& identity() const { return share_->first; }

   private:
    HeldOctets& all_;
    std::map<GuidPrefix, Share>::iterator share_;
    std::size_t octets_ = 0;
  };

  void limit(const Limits& limits) { limits_ = limits; }
  std::size_t octets() const { return octets_; }
  std::size_t identities() const { return shares_.size(); }
  /// For readers that share this object: true if the identity holds more than its limit, or more
  /// than is free. So it leaves room for another identity in each of them.
  bool exceeds_share(const GuidPrefix& identity) const;
  /// Returns the identity that must give something up, because it holds the most. Empty if
  /// everything is within the limits.
  std::optional<GuidPrefix> largest_over_limit() const;

 private:
  Limits limits_;
  std::size_t octets_ = 0;  ///< octets of all shares
  std::map<GuidPrefix, Share> shares_;
};

}  // namespace ddssec::rtps
