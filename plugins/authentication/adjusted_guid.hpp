// The adjusted participant GUID, which is bound to the certificate's subject name
// (DDS-Security 1.2, clause 10.3.3).
#pragma once

#include "base/hash.hpp"
#include "base/ids.hpp"

namespace ddssec::authentication {

/// Returns the adjusted GUID: a 1 bit, the first 47 bits of `subject_digest` (SHA-256 of the DER
/// subject name), the first 48 bits of SHA-256 over the candidate's 16 octets, and the candidate's
/// entity id.
Guid adjusted_guid(const Sha256Digest& subject_digest, const Guid& candidate);

/// True if the first 48 bits of `guid` are those of an adjusted GUID of that subject.
bool is_bound_to(const Guid& guid, const Sha256Digest& subject_digest);

/// True if the first bit of the GUID is set, as in every adjusted GUID.
bool is_adjusted(const Guid& guid);

}  // namespace ddssec::authentication
