// Finds the secrets in a configuration, and the files that it names as secrets.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace ddssec::governance::doctor {

/// What a configuration of Cyclone DDS or Fast DDS, or security.properties, holds. Comments count,
/// too.
struct SecretsInText {
  /// A private key, a PIN, or a password or passphrase itself.
  bool are_there = false;
  /// The files that are named for a password. Those of passphrases are DOC091's matter.
  std::vector<std::filesystem::path> files = {};
};
SecretsInText secrets_in(std::string_view text);

}  // namespace ddssec::governance::doctor
