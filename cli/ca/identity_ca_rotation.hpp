// Replaces an identity CA, and issues the certificates that the old one issued again.
#pragma once

#include <vector>

#include "cli/ca/ca_rotation.hpp"

namespace ddssec::cli {

/// Drafts the new identity CA with its revocation list and, if the step asks for them, the
/// participants' certificates with the same subject, key and end; then writes the log. Issues a
/// certificate only if the log contains the old one with this serial number and SHA-256 and for
/// this folder, because the old key may be stolen. A revoked participant gets none. The caller
/// holds the CA's lock (lock_records). Errors: the first of `doubtful` (issuer_unknown: a
/// certificate that the old CA did not issue) and `unwritten` if nothing is left to issue; those of
/// Authority::reissue.
Result<RotationResult> rotate_identity_ca(FileTransaction& out, const CaRotation& change,
                                          const std::vector<AffectedParticipant>& participants,
                                          const Context& context);

}  // namespace ddssec::cli
