// Checks whether a running participant on ddssec's plugins accepts what a command puts into its
// folder.
#pragma once

#include <optional>

#include "base/result.hpp"
#include "pki/certificate.hpp"
#include "pki/participant_folder.hpp"

namespace ddssec::cli {

/// Returns a warning (renewal_not_taken) if the participant does not accept the certificate that
/// follows `old`: it ends or begins earlier, or the folder has no private key that fits. `has_key`
/// is true if the command also puts the key there.
std::optional<Error> certificate_refusal_warning(const pki::ParticipantFolder& files,
                                                 const pki::Certificate& old,
                                                 const pki::Certificate& renewed, bool has_key);

/// Returns the same warning if the folder lacks the key. Empty for a folder that is not a
/// participant's.
std::optional<Error> key_not_there(const pki::ParticipantFolder& files,
                                   const pki::Certificate& certificate);

/// Returns the same warning if the folder has no permissions.
std::optional<Error> permissions_not_there(const pki::ParticipantFolder& files);

}  // namespace ddssec::cli
