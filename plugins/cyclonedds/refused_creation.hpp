// Forgets local participants whose creation access control refuses. Cyclone's core does not return
// the handles of a participant that it does not create. They would stay in the plugins until the
// domain ends, and an application that tries again would reach the limit of local identities.
#pragma once

#include "plugins/cyclonedds/access_control_adapter.hpp"

namespace ddssec::cyclonedds {

/// Returns the handle to access control, and forgets what the adapter knows of the participant.
Status forget_permissions(AccessControlAdapter& adapter, spi::PermissionsHandle permissions);

/// Returns the identity to the host's authentication plugin. Does nothing for nullptr.
void give_up_identity(const dds_security_authentication* authentication,
                      spi::IdentityHandle identity) noexcept;

/// Returns `status`. After a refusal, gives up the participant in access control and in
/// authentication. After a lack of memory nothing is given up.
Status or_give_up(AccessControlAdapter& adapter, spi::PermissionsHandle permissions, Status status);

/// Notes that the host creates the participant. Gives it up if it may not exist beside others of
/// the process (GovernanceFacts::join).
Status join_or_give_up(AccessControlAdapter& adapter, spi::PermissionsHandle permissions);

}  // namespace ddssec::cyclonedds
