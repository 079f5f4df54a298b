// Renewal lists: those that CAs keep, and those in participants' folders.
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "base/hash.hpp"
#include "cli/ca/ca_folder.hpp"
#include "cli/frame/file_transaction.hpp"
#include "governance/model.hpp"
#include "pki/crl.hpp"
#include "pki/participant_folder.hpp"
#include "pki/renewal_list.hpp"

namespace ddssec::cli {

/// The entries that a command adds to the lists of CAs. Each CA has a list of its own, renewed.pem
/// beside its certificate: that of an identity CA has certificates, that of a permissions CA
/// permissions. The caller holds the lock of each (OpenCa).
class RenewalListAdditions {
 public:
  void add(const CaPaths& ca, const pki::Certificate& renewed);
  /// Adds permissions that were signed for `file`. Permissions that name no subject are left out,
  /// with a notice: permissions_unlisted.
  void add(const CaPaths& ca, BytesView signed_permissions, const std::filesystem::path& file);
  /// Writes the entries into the files. A certificate replaces former ones of its subject, and
  /// permissions replace those that give the same and do not end later. Expired entries are
  /// removed. A file that cannot be read is started again. If a list exceeds what participants
  /// read, older permissions of a subject that has later ones are removed first, and then those
  /// that end first. Errors, after the files are written: renewal_list_malformed (started again),
  /// file_too_large (something was left out); those of FileTransaction.
  Status write(WallTime now) const;

 private:
  std::map<std::filesystem::path, pki::RenewalList> files_;
};

/// Returns the grants in the CA's list that have not expired. Empty if the list cannot be read.
std::vector<governance::Grant> listed_grants(const CaPaths& ca, WallTime now);

/// True if all grants of `next` name their subjects, and one of them gives at least the rights of a
/// former grant of its subject and ends later.
bool extends_any_grant(const governance::Permissions& next,
                       const std::vector<governance::Grant>& former);

/// The lists of the CAs in a folder.
struct RenewalsOfCas {
  pki::RenewalList list = {};
  std::vector<pki::Certificate> cas = {};  ///< the CAs whose lists were read
  std::set<std::string> revoked = {};      ///< serial numbers that the identity CA revoked
  /// Errors of lists that could not be read: those of read_file and RenewalList::parse, with hints
  /// for a CA's list.
  std::vector<Error> problems = {};
};
/// Reads the lists of both CAs at `given`, as one. `revoked` is the present revocation list of the
/// identity CA, or nullptr if there is none; certificates that it names are left out.
RenewalsOfCas renewals_of(const std::filesystem::path& given, const pki::Crl* revoked);

/// What put_renewals has found out for one folder. Most folders of a command have the same CAs and
/// the same list, so that each entry is verified once, and not once for each folder.
struct KnownRenewals {
  struct Draft {
    std::string text;
    bool is_empty = true;                 ///< the list has no entry
    std::set<std::string> left_out = {};  ///< subjects of entries that were too many
  };
  std::map<Sha256Digest, Draft> drafts = {};  ///< by the folder's list and CAs
  std::map<Sha256Digest, bool> trusted = {};  ///< verdicts, by entry and CAs
};

/// Entries for a participant's folder.
struct RenewalsForFolder {
  const pki::RenewalList& entries;
  /// The CAs whose certificates are removed if `revoked` has them.
  const std::vector<pki::Certificate>& cas;
  const std::set<std::string>& revoked;  ///< serial numbers
  WallTime now;
  KnownRenewals& known;  ///< the same for all folders of a command with the same other members
};

/// Drafts the renewal list of a participant's folder: `entries` together with the present entries,
/// as RenewalListAdditions::write combines them. Only entries of CAs in the folder are kept. A list
/// that cannot be read is made again, and one without remaining entries is emptied. Writes nothing
/// if the file would not change. Adds a notice (file_too_large) if something was left out. Errors:
/// those of FileTransaction::put.
Status put_renewals(FileTransaction& out, const pki::ParticipantFolder& files,
                    const RenewalsForFolder& what);

/// Makes the renewal list of a participant again, if it has one, after it got another certificate.
/// `ca` is the folder of its CA. The list may have only entries that the CA has revoked since, and
/// the participant would refuse it (1386). Adds the written file and a line of text to the report,
/// or the error: the certificate stands without the list.
void refresh_renewals(const std::filesystem::path& ca, const pki::ParticipantFolder& files,
                      WallTime now, Report& report);

/// Draft the renewal list of a participant's folder without certificates that none of `cas` issued,
/// or without permissions that none of them signed. Participants raise an event about such entries
/// (1386). Write nothing if there is no such entry, or if the list cannot be read. Errors: those of
/// FileTransaction::put, those of DocumentVerifier::make.
Status remove_certificates_of_others(FileTransaction& out, const std::filesystem::path& renewals,
                                     const std::vector<pki::Certificate>& cas);
Status remove_permissions_of_others(FileTransaction& out, const std::filesystem::path& renewals,
                                    const std::vector<pki::Certificate>& cas, WallTime now);

/// True if put_renewals can judge permissions, because a permissions CA is in the folder. Otherwise
/// it adds none, and the present ones stay.
bool takes_permissions(const pki::ParticipantFolder& files);

}  // namespace ddssec::cli
