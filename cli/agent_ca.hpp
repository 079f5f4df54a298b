// The CA in a folder of this machine, as the agent uses it.
#pragma once

#include <filesystem>

#include "cli/agent_messages.hpp"
#include "cli/command.hpp"

namespace ddssec::cli {

/// Issues the certificate that follows the one in a participant's folder, by the rules of `identity
/// renew`: the CA (--ca) issued the old one for this folder and did not revoke it. Subject and key
/// stay; with --rekey the key is the request's. It is valid for --days, or as long as the old one.
/// With --permissions, permissions that end before it are extended; if they cannot be, the answer
/// says why. They must be the last that the CA signed for a file (signed.jsonl). Errors: those of
/// CaOpener, check_issued_for, check_renewal_request, Authority::sign_request; outlives_ca.
Result<RenewalAnswer> renew_by_ca(const RenewalRequest& request,
                                  const std::filesystem::path& folder, const Arguments& arguments,
                                  const Context& context);

/// Success if the passphrase of the options opens the keys of --ca (with --permissions both), as
/// far as that can be tried. Not tried: a key in a token, which a wrong PIN may lock; a passphrase
/// that is typed or comes from a pipe. Errors: those of passphrase() and read_key.
Status prove_passphrase(const Arguments& arguments);

/// Success if a request may be given to a hook: it has the subject of the certificate in the folder
/// and, unless `is_rekeying`, its key. If `trust` is not empty, one of the CAs in that file must
/// have issued the certificate. Else the owner of a folder could ask for any name. Errors: those of
/// check_renewal_request and read_certificates; issuer_unknown.
Status check_asker(const RenewalRequest& request, const std::filesystem::path& trust,
                   bool is_rekeying);

}  // namespace ddssec::cli
