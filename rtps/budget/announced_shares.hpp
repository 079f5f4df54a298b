// Limits the data that is stored about the endpoints of remote participants, in all and for each
// identity.
#pragma once

#include <cstddef>
#include <map>

#include "base/ids.hpp"

namespace ddssec::rtps {

/// An identity may have no more than is free. So the first identity takes at most half, and each
/// further one still finds some.
class AnnouncedShares {
 public:
  struct Amount {
    std::size_t octets = 0;
    std::size_t endpoints = 0;

    Amount& operator+=(const Amount& more) {
      octets += more.octets;
      endpoints += more.endpoints;
      return *this;
    }
    Amount& operator-=(const Amount& less) {
      octets -= less.octets;
      endpoints -= less.endpoints;
      return *this;
    }
    bool operator==(const Amount&) const = default;
  };

  explicit AnnouncedShares(const Amount& max) : max_(max) {}

  /// True if there is room for `more` of the identity once `less` of it has been removed.
  bool has_room(const GuidPrefix& identity, const Amount& more, const Amount& less) const {
    auto own = of(identity), all = all_;
    (own += more) -= less;
    (all += more) -= less;
    return own.octets + all.octets <= max_.octets &&
           own.endpoints + all.endpoints <= max_.endpoints;
  }
  void add(const GuidPrefix& identity, const Amount& more) {
    of_identity_[identity] += more;
    all_ += more;
  }
  /// Removes an amount, which must have been added before.
  void remove(const GuidPrefix& identity, const Amount& less) {
    const auto own = of_identity_.find(identity);
    if (own == of_identity_.end()) return;
    all_ -= less;
    if ((own->second -= less) == Amount{}) of_identity_.erase(own);
  }
  Amount of(const GuidPrefix& identity) const {
    const auto own = of_identity_.find(identity);
    return own == of_identity_.end() ? Amount{} : own->second;
  }

 private:
  const Amount max_;
  Amount all_;
  std::map<GuidPrefix, Amount> of_identity_;
};

}  // namespace ddssec::rtps
