// Stops the timer by which Cyclone's core ends a handshake after 100 seconds of the system clock.
#pragma once

#include "plugins/cyclonedds/abi.hpp"

namespace ddssec::cyclonedds {

/// Stops that timer. When it ends a handshake while others are under way, Cyclone DDS 0.10 damages
/// its list of timers: it removes an element that it has already removed. Debian's 0.10.2
/// and 0.10.5 do so; pull request 1550 repaired it for later versions. The core exports the
/// function that stops the timer, but passes no handshake to a plugin. It does pass the address of
/// a member of it.
class CoreTimer {
 public:
  /// The host's dds_security_fsm_set_timeout.
  using SetTimeout = void(void* machine, void* action, std::int64_t timeout);
  /// If `set_timeout` is null, no timer is stopped.
  explicit CoreTimer(SetTimeout* set_timeout) : set_timeout_(set_timeout) {}
  /// Finds the function in the host's library. `code` is an address in the host's code, or null.
  static CoreTimer of_host(const void* code) noexcept;

  /// The arguments of a call of validate_remote_identity.
  struct Call {
    const dds_security_authentication* plugin;
    const DDS_Security_DataHolder* local_auth_request;
    const DDS_Security_GUID_t* remote;
  };
  /// Stops the timer of the handshake that makes the call. It must be called within that call,
  /// before anything can fail. False if the host has no such function, or its handshake is not laid
  /// out as in Cyclone DDS 0.10.
  bool stop(const Call& call) const noexcept;

 private:
  SetTimeout* set_timeout_;
};

}  // namespace ddssec::cyclonedds
