// The octets that readers hold out of order, counted by the identity that sent them.
#pragma once

#include <cstddef>
#include <map>
#include <optional>

#include "base/ids.hpp"

namespace ddssec::rtps {

/// Each identity has a share. So an attacker that spreads its data over many writers of its own
/// takes no room from others.
class HeldOctets {
 public:
  /// A reader that holds octets.
  class Holder {
   public:
    /// Gives up the latest change or sample of the identity. It is requested again. The reader
    /// holds at least one.
    virtual void give_up_latest(const GuidPrefix& identity) = 0;

   protected:
    ~Holder() = default;
  };

 private:
  /// What one reader holds of an identity.
  struct Part {
    std::size_t writers = 0, octets = 0;
  };
  struct Share {
    std::size_t octets = 0;
    std::map<Holder*, Part> parts = {};
  };

 public:
  static constexpr std::size_t kMax = std::size_t{256} << 20;
  static constexpr std::size_t kMaxOfOne = kMax / 2;
  struct Limits {
    std::size_t all = kMax;
    std::size_t of_one = kMaxOfOne;  ///< for all writers of one identity
  };

  /// The part of its identity's share that one writer uses in one reader, until it is destroyed.
  class Account {
   public:
    /// `all` and the holder must outlive this account. Readers that share `all` need a holder.
    Account(HeldOctets& all, const GuidPrefix& identity, Holder* holder = nullptr);
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
    std::map<Holder*, Part>::iterator part_;
    std::size_t octets_ = 0;
  };

  void limit(const Limits& limits) { limits_ = limits; }
  /// Call it if several readers use this object.
  void share() { is_shared_ = true; }
  /// Makes identities give up what exceeds the limits, after `last` has held something of this one.
  /// If readers share this object, only this identity gives up what exceeds its share. The reader
  /// that holds the most of it gives up first, and `last` before others that hold as much. So
  /// claims on one topic take no room from a topic of which less is held.
  void trim(const GuidPrefix& identity, Holder& last);
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
  bool is_shared_ = false;
  std::size_t octets_ = 0;  ///< octets of all shares
  std::map<GuidPrefix, Share> shares_;
};

}  // namespace ddssec::rtps
