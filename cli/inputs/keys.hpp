// Private keys: those in files and tokens, and new ones.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "cli/frame/command.hpp"
#include "pki/authority.hpp"
#include "pki/private_key.hpp"

namespace ddssec::cli {

/// True if the PEM text of the key is encrypted. Errors: those of load_secret.
Result<bool> is_encrypted(const std::filesystem::path& key);

/// Reads a private key. `passphrase` may be nullptr. Errors: those of pki::uri_of and
/// PrivateKey::load.
Result<pki::PrivateKey> read_key(const std::filesystem::path& path,
                                 const pki::Passphrase* passphrase);

/// The kind of key for a word. Error: usage.
Result<pki::KeySpec> key_spec_of(std::string_view key, std::string_view field);

/// The value of --key. Error: usage.
Result<pki::KeySpec> key_spec(const Arguments& arguments);

/// A key that a command generates or finds in a token.
struct NewKey {
  pki::PrivateKey key;
  std::string token_uri = {};  ///< empty: the key is not in a token
};

/// The key of --key: a kind of key, or the `pkcs11:` URI of a key. The PIN is read like a
/// passphrase unless the URI contains it. Errors: usage; those of PrivateKey::load and
/// passphrase().
Result<NewKey> new_key(const Arguments& arguments);

/// The key of a token. The PIN is read like a passphrase unless the URI contains it. Errors: those
/// of PrivateKey::load and passphrase().
Result<pki::PrivateKey> token_key(const std::string& uri, const Arguments& arguments);

}  // namespace ddssec::cli
