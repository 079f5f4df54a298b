// The addresses of a participant's endpoints that anyone can have announced.
#pragma once

#include <map>
#include <set>

#include "base/ids.hpp"
#include "wire/locator.hpp"

namespace ddssec::rtps {

/// If neither discovery nor RTPS messages are protected, anyone can announce endpoints in a
/// participant's name, at any port of its hosts. This class limits the addresses (with their ports)
/// that such announcements add to those of the participant.
class ClearAddresses {
 public:
  /// The largest number of addresses in use at a time. There are several, because other vendors let
  /// an endpoint have a port of its own.
  static constexpr std::size_t kMax = 16;

  /// Notes that the endpoint uses the address. Returns false if there is no room for a further
  /// address.
  bool use(const Locator& address, const EntityId& endpoint) {
    if (users_.size() >= kMax && !users_.contains(address)) return false;
    users_[address].insert(endpoint);
    return true;
  }
  /// Notes that the endpoint has ended.
  void release(const EntityId& endpoint) {
    for (auto at = users_.begin(); at != users_.end();) {
      at->second.erase(endpoint);
      at = at->second.empty() ? users_.erase(at) : std::next(at);
    }
  }
  /// Forgets all addresses, because no endpoint uses any.
  void clear() { users_.clear(); }

 private:
  std::map<Locator, std::set<EntityId>> users_;
};

}  // namespace ddssec::rtps
