// Decides by documents in force, or about to be, what a participant may do (DDS-Security 1.2,
// clause 9.4).
#pragma once

#include "plugins/access_control/access_control.hpp"
#include "plugins/access_control/permissions_holder.hpp"

namespace ddssec::access_control {

/// Thread-safe. Raises no events. Errors: the refusals of refusals.hpp, and the reason why there is
/// no grant.
class AccessDecisions {
 public:
  /// `clock` must outlive this object.
  AccessDecisions(const Clock& clock, bool accept_relays)
      : clock_(clock), accepts_relays_(accept_relays) {}

  /// Returns the grant of the holder that is valid now. Errors: the reason why there is none.
  Result<SharedGrant> grant_now(PermissionsHolder& holder) const {
    return holder.grant(clock_.calendar_seconds());
  }
  /// Decides whether the holder may join the domain.
  Status participant(PermissionsHolder& holder) const;
  /// Decides whether the holder may publish or subscribe on the topic.
  Status topic(PermissionsHolder& holder, std::string_view name) const;
  /// Decides whether the holder may have the endpoint.
  Status endpoint(PermissionsHolder& holder, governance::Action action,
                  const spi::EndpointRequest& request) const;
  /// Decides about an endpoint as a peer announced it, and records the announcement in the holder
  /// of the peer, as allowed or as denied.
  Status announced(PermissionsHolder& holder, governance::Action action,
                   const spi::EndpointRequest& request) const;
  /// True if the peer announced an endpoint in partitions of the local one, and that endpoint may
  /// do the action.
  bool may_as_announced(PermissionsHolder& holder, governance::Action action,
                        const spi::EndpointRequest& local) const;
  /// Decides as `announced` does, about a reader. One that may not read may still be allowed to
  /// relay.
  Result<spi::AccessControl::RemoteDatareader> reader(PermissionsHolder& holder,
                                                      const spi::EndpointRequest& request) const;
  /// Decides under the document that waits. Empty if the endpoint may not match, or if no document
  /// waits.
  std::optional<spi::AccessControl::RemoteDatareader> pending(
      PermissionsHolder& holder, governance::Action action,
      const spi::EndpointRequest& request) const;

 private:
  Status by(const governance::CompiledGovernance& rules, PermissionsHolder& holder,
            governance::Action action, const spi::EndpointRequest& request) const;
  bool may_relay(PermissionsHolder& holder, const spi::EndpointRequest& request) const;

  const Clock& clock_;
  const bool accepts_relays_;
};

}  // namespace ddssec::access_control
