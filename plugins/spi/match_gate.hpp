// Access control's say about who gets the keys of one local endpoint.
#pragma once

#include <optional>

#include "base/ids.hpp"
#include "base/result.hpp"
#include "plugins/spi/handles.hpp"

namespace ddssec::spi {

/// Cryptography asks it at every match, whatever the peer announced and the host asked before.
/// Thread-safe; lives as long as the endpoint.
class MatchGate {
 public:
  virtual ~MatchGate() = default;

  struct Peer {
    PermissionsHandle permissions;     ///< the remote participant's
    std::optional<GuidPrefix> prefix;  ///< its own, if authentication told it
    bool writes;                       ///< it writes to our reader, or reads from our writer
  };
  /// Errors: keys_not_permitted, after an event that names the peer and the rule;
  /// access_control_missing.
  virtual Status check(const Peer& peer) const = 0;
};

}  // namespace ddssec::spi
