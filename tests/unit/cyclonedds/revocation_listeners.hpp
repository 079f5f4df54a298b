// Listeners of the host that note which handle was revoked last.
#pragma once

#include <atomic>

#include "tests/unit/cyclonedds/support.hpp"

namespace ddssec::cyclonedds {

/// Notes the handle of the identity that was revoked last in `kRevoked`.
template <std::atomic<DDS_Security_IdentityHandle>& kRevoked>
inline constexpr dds_security_authentication_listener kNotesRevokedIdentity{
    [](const dds_security_authentication*,
       const DDS_Security_IdentityHandle handle) -> DDS_Security_boolean {
      kRevoked = handle;
      return 1;
    },
    nullptr};

/// Notes the handle of the permissions that were revoked last in `kRevoked`.
template <std::atomic<DDS_Security_PermissionsHandle>& kRevoked>
inline constexpr dds_security_access_control_listener kNotesRevokedPermissions{
    [](const dds_security_access_control*,
       const DDS_Security_PermissionsHandle handle) -> DDS_Security_boolean {
      kRevoked = handle;
      return 1;
    }};

}  // namespace ddssec::cyclonedds
