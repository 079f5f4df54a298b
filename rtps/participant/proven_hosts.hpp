// The hosts at which an authenticated participant has shown that it can be reached.
#pragma once

#include <algorithm>
#include <concepts>
#include <functional>

#include "wire/locator.hpp"

namespace ddssec::rtps {

/// An authorized participant may announce the address of any other host, and endpoints at any
/// address. So only its addresses at these hosts are used. A host is proven if the participant
/// answered a challenge or a handshake message that was sent to it alone, or if new messages under
/// the participant's keys, or of its handshake, came from it. Hosts are addresses without a port
/// (ParticipantCore::host_of).
/// A host stays proven for later handshakes of the same participant, as long as the participant
/// signs an address there: its GUID is bound to its certificate, and challenges are sent only
/// before the first handshake.
class ProvenHosts {
 public:
  static constexpr std::size_t kMax = 8;

  /// Returns true if the host was not proven before. If kMax hosts are known, further ones are left
  /// out.
  bool add(const Locator& host) {
    if (host.kind == LocatorKind::invalid || contains(host) || hosts_.size() >= kMax) return false;
    hosts_.push_back(host);
    return true;
  }
  bool contains(const Locator& host) const {
    return std::ranges::find(hosts_, host) != hosts_.end();
  }
  const LocatorList& all() const { return hosts_; }
  /// Forgets the hosts for which `is_used(host)` is false.
  void keep(std::predicate<const Locator&> auto is_used) {
    std::erase_if(hosts_, std::not_fn(is_used));
  }

 private:
  LocatorList hosts_;
};

}  // namespace ddssec::rtps
