// keystore verify and keystore import, for keystores that another tool made or that are in use.
#pragma once

#include "cli/commands/keystore_results.hpp"
#include "cli/frame/command.hpp"

namespace ddssec::cli {

/// Reports the prediction for each product and enclave, and keys that other users can read. Errors:
/// those of check_keystore and domain_for.
Result<Answer<VerifiedKeystore>> keystore_verify(const Arguments& arguments,
                                                 const Context& context);

/// Adds what an upstream keystore lacks: keys that only the owner can read, and a log for
/// revocation. Errors: those of check_keystore and check_alone, and issuer_unknown.
Result<Answer<ImportedKeystore>> keystore_import(const Arguments& arguments,
                                                 const Context& context);

}  // namespace ddssec::cli
