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
  /// Checks whether the holder may join the domain. Succeeds if the domain does not control who
  /// joins. Error: participant_not_allowed.
  Status check_participant(PermissionsHolder& holder) const;
  /// Checks whether the holder may use the topic: publish to it, subscribe to it, or both. Succeeds
  /// if the topic's rule does not control both actions. Errors: topic_not_covered,
  /// topic_not_allowed, and for a peer length_out_of_range.
  Status check_topic(PermissionsHolder& holder, std::string_view name) const;
  /// Checks whether the holder may do the action with this endpoint. Errors: topic_not_covered, and
  /// those of endpoint_denied_error().
  Status check_endpoint(PermissionsHolder& holder, governance::Action action,
                        const spi::EndpointRequest& request) const;
  /// Does the same for an endpoint as a peer announced it, and records the announcement in the
  /// holder of the peer's permissions, as allowed or as denied. Errors, in addition:
  /// length_out_of_range.
  Status check_announced(PermissionsHolder& holder, governance::Action action,
                         const spi::EndpointRequest& request) const;
  /// True if the topic's rule controls the action, and one of the grants does not allow the holder
  /// to do it with this endpoint. The grants are former ones of the holder.
  bool is_denied_by_any(const std::vector<SharedGrant>& grants, const PermissionsHolder& holder,
                        governance::Action action, const spi::EndpointRequest& request) const;
  /// True if the peer announced an endpoint in partitions of the local one, and that endpoint may
  /// do the action.
  bool may_as_announced(PermissionsHolder& holder, governance::Action action,
                        const spi::EndpointRequest& local) const;
  /// Checks an announced reader as check_announced() does. A reader that may not read may still be
  /// allowed to relay.
  Result<spi::AccessControl::RemoteDatareader> check_announced_reader(
      PermissionsHolder& holder, const spi::EndpointRequest& request) const;
  /// Judges an endpoint by the governance document that waits. Empty if the endpoint may not match,
  /// or if no document waits.
  std::optional<spi::AccessControl::RemoteDatareader> judge_pending(
      PermissionsHolder& holder, governance::Action action,
      const spi::EndpointRequest& request) const;

 private:
  Status check_by(const governance::CompiledGovernance& rules, PermissionsHolder& holder,
                  governance::Action action, const spi::EndpointRequest& request) const;
  bool may_relay(PermissionsHolder& holder, const spi::EndpointRequest& request) const;

  const Clock& clock_;
  const bool accepts_relays_;
};

}  // namespace ddssec::access_control
