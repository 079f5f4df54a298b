// Which instances of a builtin reader have ended and wait to be taken, and which of them give way.
#pragma once

#include <list>
#include <map>
#include <vector>

#include "base/ids.hpp"
#include "rtps/qos/qos.hpp"
#include "rtps/reliability/change.hpp"

namespace ddssec::rtps {

/// What an identity announced and withdrew takes a bounded place, whether or not the application
/// takes it from the reader; the oldest of the identity is forgotten first. It knows keys only: one
/// whose instance was taken gives way in its turn without effect.
class EndedInstances {
 public:
  static constexpr std::size_t kOctetsOfOne = std::size_t{256} << 10;  ///< of an identity
  static constexpr std::size_t kOctetsOfAll = std::size_t{8} << 20;
  static constexpr std::size_t kPrice = 512;  ///< of each instance besides its octets

  /// The instance has ended. Returns those that must be forgotten.
  std::vector<KeyHash> add(const KeyHash& key, const GuidPrefix& identity, std::size_t octets);
  /// It is there again.
  void remove(const KeyHash& key);
  /// All of them must be forgotten.
  std::vector<KeyHash> take_all();
  std::size_t octets() const { return octets_; }

 private:
  struct Ended {
    KeyHash key;
    std::size_t price;
  };
  struct Share {
    std::list<Ended> oldest_first;
    std::size_t octets = 0;
  };
  struct Place {
    GuidPrefix identity;
    std::list<Ended>::iterator at;
  };
  KeyHash take_oldest(const GuidPrefix& identity);
  GuidPrefix largest() const;

  std::map<GuidPrefix, Share> shares_;
  std::map<KeyHash, Place> places_;
  std::size_t octets_ = 0;
};

}  // namespace ddssec::rtps
