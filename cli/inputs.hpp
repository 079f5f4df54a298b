// What commands read: files, certificates, CAs with their keys, passphrases, dates.
#pragma once

#include <filesystem>
#include <optional>

#include "cli/command.hpp"
#include "pki/authority.hpp"
#include "pki/private_key.hpp"

namespace ddssec::cli {

/// A whole file. Errors: those of pki::load, with the path.
Result<Bytes> read_file(const std::filesystem::path& path, std::size_t most);

/// The first certificate of a PEM file. Errors: those of read_file and Certificate::from_pem.
Result<pki::Certificate> read_certificate(const std::filesystem::path& path);

/// Something is at `path`; a link to nothing is not.
bool is_there(const std::filesystem::path& path);

/// Nothing is wrong with a folder that is to be read. Errors: file_not_found, file_unreadable (no
/// folder, or one that may not be reached); both say what was `expected`.
Status check_directory(const std::filesystem::path& folder, std::string_view expected);

/// What `--passphrase-file` or `--passphrase-env` gives, without its line end; else, on a terminal,
/// what a person types (twice if it is a `new_one`). Errors: passphrase_needed,
/// passphrase_unusable, and those of read_file.
enum class Typed : std::uint8_t { once, twice };
Result<pki::Passphrase> passphrase(const Arguments& arguments, Typed typed,
                                   const char* prompt = "passphrase of the CA key: ");
/// A warning (passphrase_readable_by_others) if others than its owner can read the file of
/// `--passphrase-file`.
std::optional<Error> passphrase_warning(const Arguments& arguments);

/// The role's CA below `folder`: folder/identity or folder/permissions, or `folder` itself if it
/// holds ca.pem.
std::filesystem::path ca_folder(const std::filesystem::path& folder, std::string_view role);

/// True if the key's PEM text says that it is encrypted. Errors: those of pki::load_key.
Result<bool> is_encrypted(const std::filesystem::path& key);

/// A private key. `passphrase` may be null. Errors: those of pki::load_key and
/// PrivateKey::from_pem.
Result<pki::PrivateKey> read_key(const std::filesystem::path& path,
                                 const pki::Passphrase* passphrase);

/// The longest life of a certificate that can be asked for, in days.
inline constexpr int kMostDays = 36'500;

/// Whatever is issued begins so long ago: clocks differ, and Fast DDS reads the dates of a grant as
/// local time, which is up to 14 hours from UTC.
inline constexpr std::chrono::hours kBackdated{24};

/// What an option such as --within says: 30d, 12h or 4w; a bare number is days. Error: usage.
Result<std::chrono::seconds> duration(const Arguments& arguments, std::string_view option);

/// From kBackdated ago for so many days from now.
pki::Validity validity_of(int days, WallTime now);
/// The same for `--days`. Error: usage.
Result<pki::Validity> validity(const Arguments& arguments, WallTime now);

/// What kind of key a word says. Error: usage.
Result<pki::KeySpec> key_spec_of(std::string_view key, std::string_view field);
/// What --key says. Error: usage.
Result<pki::KeySpec> key_spec(const Arguments& arguments);

/// A key that a command makes, or finds in a token.
struct NewKey {
  pki::PrivateKey key;
  std::string token_uri = {};  ///< empty: it is in no token
};
/// What --key says: a kind of key, or the `pkcs11:` URI of one, whose PIN is taken as a passphrase
/// is unless the URI names it. Errors: usage; those of PrivateKey::load and passphrase().
Result<NewKey> new_key(const Arguments& arguments);
/// The key of a token, whose URI may name its PIN; else that is taken as a passphrase is. Errors:
/// those of PrivateKey::load and passphrase().
Result<pki::PrivateKey> token_key(const std::string& uri, const Arguments& arguments);

/// The certificate that `given` means: the one of a participant's folder, or the file itself.
std::filesystem::path certificate_path(const std::filesystem::path& given);

/// Asks a person at the terminal. Error: confirmation_needed if the answer is not yes, or there is
/// no terminal.
Status confirm(const std::string& question);

/// What a folder is called: the last part of its path.
std::string folder_name(const std::filesystem::path& folder);

/// A file of topics, one a line; empty lines and those that begin with '#' do not count. Errors:
/// those of read_file; usage if there is none.
Result<std::vector<std::string>> read_topics(const std::filesystem::path& file);

/// Success if `name` may name a participant's folder. `any_other`: what gives a certificate any
/// other name, for a command without --subject. Error: name_unusable.
Status check_name(std::string_view name, std::string_view any_other = {});

/// "2026-11-21".
std::string date(WallTime time);
/// A time such as 2026-11-21T00:00:00Z, or a date, which is its first second in UTC.
std::optional<WallTime> time_from(std::string_view text);
/// The same, or "+30d": so long after now.
std::optional<WallTime> time_from(std::string_view text, WallTime now);

}  // namespace ddssec::cli
