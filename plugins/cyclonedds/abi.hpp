// Cyclone DDS's plugin ABI, the part of its headers that compiles as C++ (the same in 0.10.2 and in
// the later versions), and the layout that its three plugins share behind a handle.
#pragma once

#include <cstdint>

#include <dds/security/dds_security_api_access_control.h>
#include <dds/security/dds_security_api_authentication.h>
#include <dds/security/dds_security_api_cryptography.h>
#include <dds/security/dds_security_api_defs.h>
#include <dds/security/dds_security_api_err.h>
#include <dds/security/dds_security_api_types.h>

/// Exported from the shared libraries; everything else is hidden.
#define DDSSEC_EXPORT extern "C" __attribute__((visibility("default")))

namespace ddssec::cyclonedds {

using Exception = DDS_Security_SecurityException;

/// What a DDS_Security_SharedSecretHandle points to: Cyclone's own cryptography plugin reads it,
/// and its authentication plugin hands it out, so that ours can stand beside either.
struct SharedSecretLayout {
  DDS_Security_octet* shared_secret;
  DDS_Security_long shared_secret_size;
  DDS_Security_octet challenge1[DDS_SECURITY_AUTHENTICATION_CHALLENGE_SIZE];
  DDS_Security_octet challenge2[DDS_SECURITY_AUTHENTICATION_CHALLENGE_SIZE];
};

}  // namespace ddssec::cyclonedds
