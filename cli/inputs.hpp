// The inputs of commands: files, certificates, CAs with their keys, passphrases, dates.
#pragma once

#include <filesystem>
#include <optional>

#include "cli/frame/command.hpp"
#include "pki/authority.hpp"
#include "pki/private_key.hpp"

namespace ddssec::cli {

/// Reads a whole file. Errors: those of pki::load, with the path.
Result<Bytes> read_file(const std::filesystem::path& path, std::size_t max_octets);

/// The first certificate of a PEM file. Errors: those of read_file and Certificate::from_pem.
Result<pki::Certificate> read_certificate(const std::filesystem::path& path);

/// True if something exists at `path`. False for a dangling link, and for a file in a folder that
/// cannot be searched: the command reports that when it writes there (compare pki::may_exist).
bool path_exists(const std::filesystem::path& path);

/// Success if a folder can be read. Errors: file_not_found, file_unreadable (not a folder, or not
/// accessible); both name what was `expected`.
Status check_directory(const std::filesystem::path& folder, std::string_view expected);

/// How often a user types a passphrase: twice for a new one.
enum class Typed : std::uint8_t { once, twice };
/// Returns the passphrase of `--passphrase-file` or `--passphrase-env`, without its line break. If
/// neither is given, the user is asked on a terminal. Errors: passphrase_needed,
/// passphrase_unusable, and those of read_file.
Result<pki::Passphrase> passphrase(const Arguments& arguments, Typed typed,
                                   const char* prompt = "passphrase of the CA key: ");
/// A warning (passphrase_readable_by_others) if other users can read the file of
/// `--passphrase-file`.
std::optional<Error> passphrase_warning(const Arguments& arguments);

/// The folder of the CA with that role: folder/identity or folder/permissions, or `folder` itself
/// if it contains ca.pem.
std::filesystem::path ca_folder(const std::filesystem::path& folder, std::string_view role);

/// True if the PEM text of the key is encrypted. Errors: those of load_secret.
Result<bool> is_encrypted(const std::filesystem::path& key);

/// Reads a private key. `passphrase` may be nullptr. Errors: those of pki::uri_of and
/// PrivateKey::load.
Result<pki::PrivateKey> read_key(const std::filesystem::path& path,
                                 const pki::Passphrase* passphrase);

/// The longest validity of a certificate that can be requested, in days.
inline constexpr int kMaxDays = 36'500;

/// Validity begins this long before now, because clocks differ. Fast DDS reads the dates of a grant
/// as local time, which is up to 14 hours from UTC.
inline constexpr std::chrono::hours kBackdated{24};

/// The value of an option such as --within: 30d, 12h or 4w; a plain number means days. Error:
/// usage.
Result<std::chrono::seconds> duration(const Arguments& arguments, std::string_view option);

/// A validity from kBackdated ago until `days` days from now.
pki::Validity validity_of(int days, WallTime now);
/// The same for `--days`. Error: usage.
Result<pki::Validity> validity(const Arguments& arguments, WallTime now);

/// The URL of --ocsp-responder; empty if it is not given. Error: usage.
Result<std::string> ocsp_responder(const Arguments& arguments);
/// The validity of a certificate that replaces `former`. It does not begin before that of `former`,
/// because a running participant does not accept such a certificate. This does not apply if
/// `former` is not valid yet: it was issued while the clock was ahead.
pki::Validity validity_after(const pki::Certificate& former, pki::Validity wanted, WallTime now);

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

/// The path of a certificate: the one in a participant's folder, or `given` itself.
std::filesystem::path certificate_path(const std::filesystem::path& given);

/// Asks the user at the terminal. Error: confirmation_needed if the answer is not yes or there is
/// no terminal.
Status confirm(const std::string& question);

/// The name of a folder: the last part of its path.
std::string folder_name(const std::filesystem::path& folder);

/// Reads a file with one topic per line; empty lines and those that begin with '#' are skipped.
/// Errors: those of read_file; usage if there is no topic.
Result<std::vector<std::string>> read_topics(const std::filesystem::path& file);

/// Success if `name` is a valid name for a participant's folder. `any_other` says how a certificate
/// gets any other name, for a command without --subject. Error: name_unusable.
Status check_name(std::string_view name, std::string_view any_other = {});

/// For example "2026-11-21".
std::string date(WallTime time);
/// A time such as 2026-11-21T00:00:00Z, or a date, which is its first second in UTC.
std::optional<WallTime> time_from(std::string_view text);
/// The same, or "+30d" or "-2d" for a time that long after or before `now`. Empty for a time before
/// 1970.
std::optional<WallTime> time_from(std::string_view text, WallTime now);

}  // namespace ddssec::cli
