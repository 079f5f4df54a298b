// A CA in a folder: certificate, key, log of issued certificates, revocation list.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/folders/ca_paths.hpp"
#include "cli/frame/command.hpp"
#include "cli/frame/file_lock.hpp"
#include "cli/frame/file_transaction.hpp"
#include "cli/frame/new_folder.hpp"
#include "cli/inputs/files.hpp"
#include "cli/inputs/keys.hpp"
#include "pki/authority.hpp"
#include "pki/issue_log.hpp"

namespace ddssec::cli {

/// The value of --role, which must be one of the two roles. Error: usage.
Result<std::string> role_option(const Arguments& arguments);

/// A CA that can sign.
struct OpenCa {
  CaPaths paths;
  pki::Authority authority;
  /// All certificates in the certificate's file: the trust anchors that participants need.
  std::string trust_pem;
  /// The lock, taken before the files were read: see lock_records.
  std::optional<FileLock> lock = {};

  const pki::Certificate& certificate() const { return authority.certificate(); }
};

/// Opens CAs for one command, and asks for the passphrase only once.
class CaOpener {
 public:
  explicit CaOpener(const Arguments& arguments) : arguments_(arguments) {}

  /// Opens the CA of these files for exclusive use as long as the result lives. It waits for
  /// another command that signs or rotates, and only then reads the files. The key is used only if
  /// no other user can read it, unless --insecure-key-mode is given. If both CAs are needed, open
  /// the identity CA first, so that two commands do not wait for each other. Errors:
  /// link_untrusted (a link in the path of the key that another user can change, except one to a
  /// file beside it), key_readable_by_others, those of passphrase() for an encrypted key, of
  /// lock_records, read_file, Authority::load.
  Result<OpenCa> open(const CaPaths& paths);
  /// Opens the CA of --ca with that role. Errors as above, and those of check_signing_ca.
  Result<OpenCa> open(std::string_view role);

  /// Returns the passphrase that opened an encrypted key so far, or nullptr if none was encrypted.
  const pki::Passphrase* used_passphrase() const { return passphrase_ ? &*passphrase_ : nullptr; }

 private:
  Status prepare(const std::filesystem::path& key);
  Result<pki::PrivateKey> key(const std::filesystem::path& path);

  const Arguments& arguments_;
  std::optional<pki::Passphrase> passphrase_;
};

/// Reads all certificates of a file. Errors: those of read_file and Certificate::bundle_from_pem.
Result<std::vector<pki::Certificate>> read_certificates(const std::filesystem::path& path);
/// Returns the certificates as PEM text without any text between them.
std::string to_pem(const std::vector<pki::Certificate>& certificates);

/// Reads the log of what a CA issued; empty if it has no log. Unreadable lines become notices
/// (notice_unreadable_lines). Errors: those of read_file.
Result<pki::IssueLog> read_issue_log(const CaPaths& paths);

/// Success if each of these lines is short enough for all commands to read it from a log. Error:
/// length_out_of_range.
Status check_log_lines(const std::filesystem::path& log, std::string_view lines);

/// Appends lines to the log of what a CA issued. Errors: length_out_of_range, those of
/// append_lines.
Status log_issued(const CaPaths& paths, std::string_view lines);

/// Locks the CA's files: while the lock lives, no other command signs, revokes, rotates or lists
/// anything of this CA. Take it before reading the first file whose content decides what is
/// written. The lock is on the key file: only its owner can open that, so no other user can hold
/// the lock. Empty if this user has no key here that can be read: then the command cannot change
/// the CA. Errors: those of FileLock::of.
Result<std::optional<FileLock>> lock_records(const CaPaths& paths);

/// Adds a new key to a new folder under `name`. For a key in a token, adds a *.p11 file with the
/// key's URI instead.
Status add_key(NewFolder& folder, const std::filesystem::path& name, const NewKey& key,
               const pki::Passphrase* passphrase = nullptr);

/// Returns the subject of a new CA, "CN=TITLE ROLE CA" (the role may be empty). Special characters
/// in the title are escaped.
std::string ca_subject(std::string_view title, std::string_view role);

/// Adds a new CA's certificate and key to a new folder.
Status add_ca(NewFolder& folder, const CaPaths& names, std::string_view trust_pem,
              const NewKey& key, const pki::Passphrase* passphrase);

}  // namespace ddssec::cli
