// A CA as it lies in a folder: certificate, key, what it issued, its revocation list.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/command.hpp"
#include "cli/file_lock.hpp"
#include "cli/inputs.hpp"
#include "cli/transaction.hpp"
#include "pki/authority.hpp"
#include "pki/issue_log.hpp"

namespace ddssec::cli {

/// Where a CA's files are.
struct CaPaths {
  std::filesystem::path certificate;  ///< the current certificate first; others that it needs after
  std::filesystem::path key;
  std::filesystem::path log;  ///< pki::IssueLog
  std::filesystem::path crl;
  std::filesystem::path signed_log;  ///< pki::SigningLog, of a permissions CA
};

/// The files of a CA below its folder (ca.pem, ca.key.pem, issued.jsonl, crl.pem,
/// signed.jsonl).
CaPaths ca_paths_in(const std::filesystem::path& folder);

/// The files of the `role`'s CA ("identity", "permissions"), given what `ca create`, `init` or
/// `keystore create` made, or a folder with ca.pem.
CaPaths ca_paths(const std::filesystem::path& given, std::string_view role);

/// The certificate of a CA, given that or what ca_paths() takes.
std::filesystem::path ca_certificate_path(const std::filesystem::path& given,
                                          std::string_view role);

/// What --role says where it must be one of both. Error: usage.
Result<std::string> one_role(const Arguments& arguments);

/// A CA that can sign.
struct OpenCa {
  CaPaths paths;
  pki::Authority authority;
  /// Everything in the certificate's file: what participants must be given.
  std::string trust_pem;
  /// Held from before the files were read: see lock_records.
  std::optional<FileLock> lock = {};

  const pki::Certificate& certificate() const { return authority.certificate(); }
};

/// Opens CAs for one command; the passphrase is asked for once.
class CaOpener {
 public:
  explicit CaOpener(const Arguments& arguments) : arguments_(arguments) {}

  /// The CA of these files, which this command has to itself as long as the result lives: another
  /// command that signs or rotates is waited for, and only then is anything read. Its key is used
  /// only if no other user than its owner can read it, unless --insecure-key-mode is given. Of two
  /// CAs the identity CA is opened first, so that two commands do not wait for each other. Errors:
  /// key_readable_by_others, those of passphrase() for an encrypted key, of lock_records,
  /// read_file, Authority::load.
  Result<OpenCa> open(const CaPaths& paths);
  /// The `role`'s CA of --ca. Errors as above, and those of check_signing_ca.
  Result<OpenCa> open(std::string_view role);

  /// What opened an encrypted key so far; null if none was encrypted.
  const pki::Passphrase* used_passphrase() const { return passphrase_ ? &*passphrase_ : nullptr; }

 private:
  Status prepare(const std::filesystem::path& key);
  Result<pki::PrivateKey> key(const std::filesystem::path& path);

  const Arguments& arguments_;
  std::optional<pki::Passphrase> passphrase_;
};

/// Every certificate of a file, as PEM text without anything that stood between them.
/// Errors: those of read_file and Certificate::bundle_from_pem.
Result<std::vector<pki::Certificate>> read_certificates(const std::filesystem::path& path);
std::string to_pem(const std::vector<pki::Certificate>& certificates);

/// What a CA issued; nothing if it has no log. Lines that cannot be read are noticed
/// (notice_unreadable_lines). Errors: those of read_file.
Result<pki::IssueLog> read_issue_log(const CaPaths& paths);

/// Success if every command can read these lines of a log. Error: length_out_of_range.
Status check_log_lines(const std::filesystem::path& log, std::string_view lines);

/// Adds lines to the log of what a CA issued. Errors: length_out_of_range, those of append_lines.
Status log_issued(const CaPaths& paths, std::string_view lines);

/// No other command signs, revokes, rotates or lists anything of this CA while the lock lives.
/// Taken before the first of its files is read whose content decides what is written. It is on the
/// key, which only its owner can open, so that no other user can hold it. Nothing if the key is not
/// here, or not for this user: then the command can change nothing of the CA. Errors: those of
/// FileLock::of.
Result<std::optional<FileLock>> lock_records(const CaPaths& paths);

/// Puts a new key into a folder to be: as `name`, or if it is in a token, its URI as the *.p11 in
/// that place.
Status add_key(NewFolder& folder, const std::filesystem::path& name, const NewKey& key,
               const pki::Passphrase* passphrase = nullptr);

/// The subject of a new CA, "CN=TITLE ROLE CA" (the role may be empty), where no character of the
/// title means anything.
std::string ca_subject(std::string_view title, std::string_view role);

/// Puts a new CA's certificate and key into a folder to be.
Status add_ca(NewFolder& folder, const CaPaths& names, std::string_view trust_pem,
              const NewKey& key, const pki::Passphrase* passphrase);

}  // namespace ddssec::cli
