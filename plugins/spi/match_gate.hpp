// The access control check that decides which peers get the keys of one local endpoint.
#pragma once

#include <optional>

#include "base/ids.hpp"
#include "base/result.hpp"
#include "plugins/spi/handles.hpp"

namespace ddssec::spi {

/// Decides about matches. Cryptography calls `check` at every match, whatever the peer announced
/// and whatever the host asked before. Thread-safe. Lives as long as the endpoint.
class MatchGate {
 public:
  virtual ~MatchGate() = default;

  /// The remote side of a match.
  struct Peer {
    PermissionsHandle permissions;  ///< handle for the remote participant
    /// The prefix of the remote participant; empty if authentication did not provide it.
    std::optional<GuidPrefix> prefix;
    /// True for its writer and the local reader; false for its reader and the local writer.
    bool writes;
    /// True if it has announced a writer (a reader) without saying how that is protected. The match
    /// may then be with an endpoint that the host never asked about.
    bool hides_endpoints = false;
  };
  /// Success if the peer may have the keys. Errors: keys_not_permitted, after an event that names
  /// the peer and the rule; access_control_missing; out_of_memory.
  virtual Status check(const Peer& peer) const = 0;
};

}  // namespace ddssec::spi
