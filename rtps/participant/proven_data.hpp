// The part of a participant's announced data that counts once the participant has authenticated.
#pragma once

#include <algorithm>

#include "rtps/discovery/participant_data.hpp"
#include "wire/vendor.hpp"

namespace ddssec::rtps {

/// The shortest lease that counts although anyone may have announced it. It lasts until the data
/// that the participant announces under its keys has arrived. It is short because Cyclone DDS
/// 0.10.2 often announces none, and the end of such a participant must be noticed in time.
inline constexpr Duration kMinUnprovenLease{{2, 0}};

/// Returns the lease that counts.
inline Duration lease_that_counts(const Duration& announced, bool is_proven) {
  return is_proven ? announced : std::max(announced, kMinUnprovenLease);
}

/// Takes over the data that the peer signed but that no handshake needs. For Cyclone DDS this is
/// its version, which determines how it lays out keys. Cyclone DDS signs no lease, but announces it
/// by DCPSParticipantsSecure. Until that arrives, only the lease of SPDP is known, which may be
/// forged. ddssec also signs its name and user data, unless DCPSParticipantsSecure carries them.
/// For other vendors, name and user data stay as announced.
inline void adopt_proven(ParticipantData& known, const ParticipantData& proven) {
  known.vendor = proven.vendor;
  const bool is_cyclone = proven.vendor == kVendorCyclone;
  if (!is_cyclone || !proven.vendor_version.empty()) known.vendor_version = proven.vendor_version;
  known.builtin_endpoints = proven.builtin_endpoints;
  known.lease_duration =
      lease_that_counts(is_cyclone ? known.lease_duration : proven.lease_duration, !is_cyclone);
  if (proven.vendor != kVendorDdssec) return;
  known.entity_name = proven.entity_name;
  known.user_data = proven.user_data;
}

}  // namespace ddssec::rtps
