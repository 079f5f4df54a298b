// Checks a certificate in a participant's folder against the CA's log. The folder may have come
// back from its device, which can put any certificate that it saw into the folder. The log records
// what the CA issued for the folder.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "cli/ca/ca_folder.hpp"

namespace ddssec::cli {

/// Success if the CA (or the same CA before its renewal) issued the certificate in `file`. Validity
/// dates are not checked. Error: issuer_unknown.
Status check_issuer(const pki::Certificate& certificate, const OpenCa& ca,
                    const std::filesystem::path& file);

/// The status of a certificate in a folder, by the log.
enum class LogStatus : std::uint8_t {
  own,       ///< issued for this folder
  moved,     ///< issued for another folder, and the log does not know this one
  foreign,   ///< issued for another folder, while the log has other certificates for this one
  unlogged,  ///< not in the log, or the log has another certificate with this serial number
};

/// Returns the status of a certificate; `log` is that of the CA. A folder that moved together with
/// its CA counts as the same folder. So does an enclave of a keystore whose certificate has the
/// enclave's name and is not in the log (sros2).
LogStatus log_status_of(const pki::Certificate& certificate, const std::filesystem::path& folder,
                        const CaPaths& ca, const pki::IssueLog& log);

/// True if the log contains exactly this certificate, by its SHA-256: the CA issued it, or the same
/// CA before its rotation.
bool is_logged(const pki::Certificate& certificate, const pki::IssueLog& log);

/// Success if the certificate was issued for the folder, or if its subject is `subject`, which the
/// command line names. With an empty `subject`, only a certificate for the folder is accepted.
/// Errors: certificate_unlogged, certificate_of_another_folder, those of SubjectName::parse.
Status check_own(const pki::Certificate& certificate, const std::filesystem::path& folder,
                 const CaPaths& ca, const pki::IssueLog& log, const std::string& subject);

/// Returns the folder to log for the successor of a certificate. If the certificate was issued for
/// the given folder, that is the folder in its log entry; otherwise the given folder, absolute. The
/// given path is not used in the first case, because it may later lead to another participant's
/// folder.
std::filesystem::path recorded_folder(const pki::Certificate& certificate,
                                      const std::filesystem::path& folder, const CaPaths& ca,
                                      const pki::IssueLog& log);

/// Success if no other folder has the certificate, according to the log and to `seen` (folders by
/// serial number), to which it is added. Renewals rely on the folder that the log records. Error:
/// certificate_of_another_folder.
Status check_alone(const pki::Certificate& certificate, const std::filesystem::path& folder,
                   const CaPaths& ca, const pki::IssueLog& log,
                   std::map<std::string, std::filesystem::path>& seen);

/// The key of a certificate that follows another one.
enum class NextKey : std::uint8_t { same, fresh };

/// Returns the serial number of the revoked certificate because of which this one must not be
/// renewed; empty if there is none. It is the certificate itself; a later one of its subject or
/// folder; one that was revoked after this one had expired; or any with the same key, unless the
/// successor gets a new key. The CA's present list counts like the log. Errors: those of
/// listed_revocations.
Result<std::string> revoked_serial(const pki::Certificate& certificate, const CaPaths& ca,
                                   const pki::IssueLog& log, NextKey next);
/// Success if revoked_serial() is empty. Errors: certificate_revoked, with `file`; those of
/// listed_revocations.
Status check_not_revoked(const pki::Certificate& certificate, const std::filesystem::path& file,
                         const CaPaths& ca, const pki::IssueLog& log, NextKey next);

/// Success if no certificate of this key was revoked, by the log or by the CA's present list.
/// Errors: certificate_revoked, with `file`; those of listed_revocations.
Status check_key_not_revoked(const pki::Certificate& certificate, const std::filesystem::path& file,
                             const CaPaths& ca, const pki::IssueLog& log);

/// Returns a line about the certificate in `file`, which is about to be replaced and stays valid
/// although no file will hold it. Empty if it has expired or was revoked. `given` is the CA's
/// folder as the user named it.
std::string former_certificate_text(const std::filesystem::path& file,
                                    const std::filesystem::path& given, WallTime now);

/// Success if the CA issued the folder's certificate for this folder and did not revoke it. Errors:
/// those of check_issuer, check_own and check_not_revoked.
Status check_issued_for(const pki::Certificate& certificate, const std::filesystem::path& folder,
                        const CaPaths& ca);

}  // namespace ddssec::cli
