// The samples and instances that a reader holds of each identity.
#pragma once

#include <cstddef>
#include <map>
#include <memory>

#include "base/ids.hpp"

namespace ddssec::rtps {

/// The counters of one identity: the number of samples, the octets of samples and keys, how often
/// one of its writers has an instance, and the number of instances that count for it.
struct HeldShare {
  std::size_t samples = 0, octets = 0, joins = 0, instances = 0;
};
/// Everything that is held of an identity refers to its share. nullptr means that nothing is
/// counted.
using HeldShareOf = std::shared_ptr<HeldShare>;

/// Finds the share of an identity while anything holds it.
class HeldShares {
 public:
  HeldShareOf of(const GuidPrefix& identity) {
    if (shares_.size() >= sweep_at_) {
      std::erase_if(shares_, [](const auto& entry) { return entry.second.expired(); });
      sweep_at_ = 2 * shares_.size() + kFew;
    }
    auto& known = shares_[identity];
    auto out = known.lock();
    if (!out) known = out = std::make_shared<HeldShare>();
    return out;
  }

 private:
  static constexpr std::size_t kFew = 16;

  std::map<GuidPrefix, std::weak_ptr<HeldShare>> shares_;
  std::size_t sweep_at_ = kFew;
};

}  // namespace ddssec::rtps
