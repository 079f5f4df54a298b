// Replaces a permissions CA, and signs what the old one signed again.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "cli/ca/ca_rotation.hpp"

namespace ddssec::cli {

/// Drafts the new permissions CA and signs every document of `shared` again, and those of the
/// participants if the step asks for it; then writes the log. Signs only documents that the old CA
/// signed and that its log contains, because the old key may be stolen. A participant with any
/// other document is left unchanged. The caller holds the CA's lock (lock_records). Errors: those
/// of document_of() for a shared document; the first of `doubtful` and `unwritten` if no
/// participant is updated.
Result<RotationResult> rotate_permissions_ca(FileTransaction& out, const CaRotation& change,
                                             const std::vector<AffectedParticipant>& participants,
                                             const std::vector<std::filesystem::path>& shared,
                                             const Context& context);

/// The participants that have a document or a certificate of another permissions CA than that of
/// `trust_pem`, which is in place. An earlier command could not write their files.
std::vector<AffectedParticipant> left_with_another_ca(
    const std::vector<AffectedParticipant>& participants, std::string_view trust_pem, WallTime now);

/// Like rotate_permissions_ca() for participants that an earlier command could not update:
/// `change.ca` is in place already, and nothing is written for the CA itself or for `shared`.
Result<RotationResult> finish_permissions_rotation(
    FileTransaction& out, const CaRotation& change,
    const std::vector<AffectedParticipant>& participants,
    const std::vector<std::filesystem::path>& shared, const Context& context);

}  // namespace ddssec::cli
