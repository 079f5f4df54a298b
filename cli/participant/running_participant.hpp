// Whether a participant that runs on ddssec's plugins takes what a command puts into its folder.
#pragma once

#include <optional>

#include "base/result.hpp"
#include "pki/certificate.hpp"
#include "pki/participant_folder.hpp"

namespace ddssec::cli {

/// A warning (renewal_not_taken) if it does not take the certificate that follows `old`: because
/// that one ends or begins earlier, or because no private key that fits is in the folder.
/// `has_key`: the command puts the key there too.
std::optional<Error> certificate_not_taken(const pki::ParticipantFolder& files,
                                           const pki::Certificate& old,
                                           const pki::Certificate& renewed, bool has_key);

/// The same for the key alone. A folder that is no participant's has no key.
std::optional<Error> key_not_there(const pki::ParticipantFolder& files,
                                   const pki::Certificate& certificate);

/// The same for permissions: if the folder has none.
std::optional<Error> permissions_not_there(const pki::ParticipantFolder& files);

}  // namespace ddssec::cli
