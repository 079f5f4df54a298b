// The hosts at which an authenticated participant can be reached, as it has shown.
#pragma once

#include <algorithm>

#include "wire/locator.hpp"

namespace ddssec::rtps {

/// An authorized participant may announce the address of any other host, and endpoints at any
/// address. Only its addresses at these hosts are used. A host is proven if the participant
/// answered a challenge or a handshake message that was sent to it alone, or if new messages under
/// the participant's keys, or of its handshake, came from it. Hosts are addresses without a port
/// (ParticipantCore::host_of).
class ProvenHosts {
 public:
  static constexpr std::size_t kMax = 8;

  /// Returns true if the host was not proven before. Further hosts than kMax are left out.
  bool add(const Locator& host) {
    if (host.kind == LocatorKind::invalid || contains(host) || hosts_.size() >= kMax) return false;
    hosts_.push_back(host);
    return true;
  }
  bool contains(const Locator& host) const {
    return std::ranges::find(hosts_, host) != hosts_.end();
  }
  const LocatorList& all() const { return hosts_; }
  void clear() { hosts_.clear(); }

 private:
  LocatorList hosts_;
};

}  // namespace ddssec::rtps
