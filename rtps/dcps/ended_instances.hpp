// The instances of a builtin reader that have ended but were not taken yet, and the order in which
// they are forgotten.
#pragma once

#include <list>
#include <map>
#include <vector>

#include "base/ids.hpp"
#include "rtps/qos/qos.hpp"
#include "rtps/reliability/change.hpp"

namespace ddssec::rtps {

/// Limits the memory of entities that an identity announced and withdrew, whether or not the
/// application takes them from the reader. If an identity exceeds its limit, its oldest instance is
/// forgotten first. The class stores only keys: an instance that was taken still occupies its place
/// until its turn, and forgetting it has no effect.
class EndedInstances {
 public:
  static constexpr std::size_t kMaxOctetsPerIdentity = std::size_t{256}
                                                       << 10;  ///< limit for one identity
  static constexpr std::size_t kMaxOctets = std::size_t{8} << 20;
  static constexpr std::size_t kPrice = 512;  ///< added to the octets of each instance

  /// Adds an instance that has ended. Returns the instances that the reader must forget.
  std::vector<KeyHash> add(const KeyHash& key, const GuidPrefix& identity, std::size_t octets);
  /// Removes an instance, because it exists again.
  void remove(const KeyHash& key);
  /// Removes all instances and returns them; the reader must forget them.
  std::vector<KeyHash> take_all();
  std::size_t octets() const { return octets_; }

 private:
  struct EndedInstance {
    KeyHash key;
    std::size_t price;
  };
  struct Share {
    std::list<EndedInstance> oldest_first;
    std::size_t octets = 0;
  };
  struct Place {
    GuidPrefix identity;
    std::list<EndedInstance>::iterator at;
  };
  KeyHash take_oldest(const GuidPrefix& identity);
  GuidPrefix largest() const;

  std::map<GuidPrefix, Share> shares_;
  std::map<KeyHash, Place> places_;
  std::size_t octets_ = 0;
};

}  // namespace ddssec::rtps
