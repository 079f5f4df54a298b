// Finds the secrets in a configuration, and the files that it names as secrets.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace ddssec::governance::doctor {

/// The secrets in a configuration of Cyclone DDS or Fast DDS, or in security.properties. Those in
/// comments count, too.
struct SecretsInText {
  /// True if the text has a private key, a PIN, or a password or passphrase itself.
  bool are_there = false;
  /// The files that are named for a password.
  std::vector<std::filesystem::path> files = {};
  /// The files that are named for passphrases of pre-shared keys.
  std::vector<std::filesystem::path> passphrase_files = {};
};
SecretsInText secrets_in(std::string_view text);

}  // namespace ddssec::governance::doctor
