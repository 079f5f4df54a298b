// keystore verify, keystore import: keystores that others made, or that have been in use.
#pragma once

#include "cli/command.hpp"

namespace ddssec::cli {

/// What each product would say of each enclave, and which keys other users can read. Errors: those
/// of check_keystore and domain_for.
Result<Report> keystore_verify(const Arguments& arguments, const Context& context);

/// Adds what a keystore of upstream lacks: keys for their owner only, and a log for revocation.
/// Errors: those of check_keystore and check_alone, and issuer_unknown.
Result<Report> keystore_import(const Arguments& arguments, const Context& context);

}  // namespace ddssec::cli
