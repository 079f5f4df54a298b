// A certificate as it lies in a participant's folder, held against the CA's log. The folder may
// have come back from its device, which can put any certificate into it that it saw: what the CA
// issued for the folder is what its log says.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "cli/ca_folder.hpp"

namespace ddssec::cli {

/// Success if the CA (or itself before it was renewed) issued the certificate in `file`, whatever
/// its dates. Error: issuer_unknown.
Status check_issuer(const pki::Certificate& certificate, const OpenCa& ca,
                    const std::filesystem::path& file);

/// What the log says of a certificate in a folder.
enum class Belonging : std::uint8_t {
  own,       ///< issued for this folder
  moved,     ///< issued for another folder, and the log does not know this one
  foreign,   ///< issued for another folder, and this one got others
  unlogged,  ///< not in the log, or another of the same serial number
};

/// The log must be the CA's. A folder that moved together with its CA is the same folder; so is an
/// enclave of a keystore whose certificate has the enclave's name and is not in the log (sros2).
Belonging belonging_of(const pki::Certificate& certificate, const std::filesystem::path& folder,
                       const CaPaths& ca, const pki::IssueLog& log);

/// True if the log has exactly this certificate, by its SHA-256: the CA issued it, or itself before
/// it was rotated.
bool is_logged(const pki::Certificate& certificate, const pki::IssueLog& log);

/// Success if the certificate is the folder's own, or if `subject`, which the command line names,
/// is its subject. `subject` may be empty: then nothing else than the folder's own will do.
/// Errors: certificate_unlogged, certificate_of_another_folder, those of SubjectName::parse.
Status check_own(const pki::Certificate& certificate, const std::filesystem::path& folder,
                 const CaPaths& ca, const pki::IssueLog& log, const std::string& subject);

/// Success if no other folder has the certificate, by the log and by `seen` (folders by serial
/// number), to which it is added. Once the log has it for a folder, renewals go by that. Error:
/// certificate_of_another_folder.
Status check_alone(const pki::Certificate& certificate, const std::filesystem::path& folder,
                   const CaPaths& ca, const pki::IssueLog& log,
                   std::map<std::string, std::filesystem::path>& seen);

/// Whose key a certificate is to be for that follows another.
enum class NextKey : std::uint8_t { same, fresh };

/// The revoked certificate because of which this one has no successor: itself; a later one of its
/// subject or folder; one that was revoked when this one had ended; any of the same key, unless the
/// successor gets another. Empty if there is none. The CA's present list counts as the log does.
/// Errors: those of listed_revocations.
Result<std::string> revoked_serial(const pki::Certificate& certificate, const CaPaths& ca,
                                   const pki::IssueLog& log, NextKey next);
/// The same as an error: certificate_revoked, with `file`.
Status check_not_revoked(const pki::Certificate& certificate, const std::filesystem::path& file,
                         const CaPaths& ca, const pki::IssueLog& log, NextKey next);

/// Success if no certificate of this key was revoked, by the log or by the CA's present list.
/// Errors: certificate_revoked, with `file`; those of listed_revocations.
Status check_key_not_revoked(const pki::Certificate& certificate, const std::filesystem::path& file,
                             const CaPaths& ca, const pki::IssueLog& log);

/// Success if the CA issued the folder's certificate for this folder and did not revoke it. Errors:
/// those of check_issuer, check_own and check_not_revoked.
Status check_issued_for(const pki::Certificate& certificate, const std::filesystem::path& folder,
                        const CaPaths& ca);

}  // namespace ddssec::cli
