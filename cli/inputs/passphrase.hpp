// What a user types, or gives in a file or a variable instead: passphrases and confirmations.
#pragma once

#include <optional>
#include <string>

#include "cli/frame/command.hpp"
#include "pki/private_key.hpp"

namespace ddssec::cli {

/// Returns the passphrase of `--passphrase-file` or `--passphrase-env`, without its line break. If
/// neither is given, the user is asked on a terminal. Errors: passphrase_needed,
/// passphrase_unusable, and those of read_file.
Result<pki::Passphrase> passphrase(const Arguments& arguments,
                                   const char* prompt = "passphrase of the CA key: ");
/// As passphrase, for that of a new key, which the user types twice.
Result<pki::Passphrase> new_passphrase(const Arguments& arguments);
/// A warning (passphrase_readable_by_others) if other users can read the file of
/// `--passphrase-file`.
std::optional<Error> passphrase_warning(const Arguments& arguments);

/// Asks the user at the terminal. Error: confirmation_needed if the answer is not yes or there is
/// no terminal.
Status confirm(const std::string& question);

}  // namespace ddssec::cli
