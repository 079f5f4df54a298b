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
#include "pki/crl.hpp"
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

  const pki::Certificate& certificate() const { return authority.certificate(); }
};

/// Opens CAs for one command; the passphrase is asked for once.
class CaOpener {
 public:
  explicit CaOpener(const Arguments& arguments) : arguments_(arguments) {}

  /// The CA of these files. Its key is used only if nobody but its owner can read it, unless
  /// --insecure-key-mode is given. Errors: key_readable_by_others, those of passphrase() for an
  /// encrypted key, of read_file, Authority::load.
  Result<OpenCa> open(const CaPaths& paths);
  /// The `role`'s CA of --ca. Errors as above, and those of check_signing_ca.
  Result<OpenCa> open(std::string_view role);

  /// What opened an encrypted key so far; null if none was encrypted.
  const pki::Passphrase* used_passphrase() const { return passphrase_ ? &*passphrase_ : nullptr; }

 private:
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

/// The list in a file, or nothing if there is no such file. Errors: those of read_file and
/// Crl::all_from; crl_malformed if the file holds no list.
Result<std::optional<pki::Crl>> read_crl(const std::filesystem::path& path);

/// No other command revokes, renews or lists anything of this CA while the lock lives. Taken when
/// the CA is open, since a passphrase may be waited for, and before the log is read. It is on the
/// key, which only its owner can open, so that no other user can hold it. Errors: those
/// of FileLock::of.
Result<FileLock> lock_records(const CaPaths& paths);

/// Whether the CA's present list names everything that its log says is revoked; it does not if a
/// crash came between the two. Errors: those of read_crl and Crl::revoked.
Result<bool> lists_all(const CaPaths& paths, const pki::IssueLog& log);

/// How long a list holds that a command makes on its way.
inline constexpr int kListDays = 180;

/// The list that follows the CA's present one: everything revoked by the log and by that list.
/// Errors: those of read_crl and Authority::make_crl.
Result<pki::Crl> next_crl(const OpenCa& ca, const pki::IssueLog& log, WallTime now, int days);

/// The same, for kListDays; but a list that names nothing holds as long as the CA, so that it need
/// not be renewed before a certificate is revoked.
Result<pki::Crl> routine_crl(const OpenCa& ca, const pki::IssueLog& log, WallTime now);

/// A new CA's list, which names nothing and holds as long as the CA. Errors: those of make_crl.
Result<pki::Crl> first_crl(const pki::Authority& ca);

/// The CA's present list, in PEM, for a participant that is made now; empty if there is none or it
/// is over. Errors: those of read_crl.
Result<std::string> list_for_newcomers(const CaPaths& paths, WallTime now);

/// Puts a new key into a folder to be: as `name`, or if it is in a token, its URI as the *.p11 in
/// that place.
Status add_key(NewFolder& folder, const std::filesystem::path& name, const NewKey& key,
               const pki::Passphrase* passphrase = nullptr);

/// Puts a new CA's certificate and key into a folder to be.
Status add_ca(NewFolder& folder, const CaPaths& names, std::string_view trust_pem,
              const NewKey& key, const pki::Passphrase* passphrase);

}  // namespace ddssec::cli
