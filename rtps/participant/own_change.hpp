// A change of the data that the local participant announces about itself.
#pragma once

#include <optional>

#include "rtps/transport/network_interfaces.hpp"

namespace ddssec::rtps {

/// A change of what this participant announces about itself. Empty members stay as they are.
struct OwnChange {
  struct Addresses {
    std::vector<NetworkInterface> interfaces;
    LocatorList metatraffic, user;
  };
  std::optional<Bytes> user_data = {};
  /// Authenticated participants of ddssec follow to the new addresses if the governance protects
  /// discovery or messages. Without security, and if none of the former addresses is left, all
  /// participants are discovered again.
  std::optional<Addresses> addresses = {};
};

}  // namespace ddssec::rtps
