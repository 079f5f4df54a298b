// Renewal lists: those that CAs keep, and those in participants' folders.
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "cli/ca/ca_folder.hpp"
#include "cli/frame/file_transaction.hpp"
#include "governance/model.hpp"
#include "pki/crl.hpp"
#include "pki/participant_folder.hpp"
#include "pki/renewal_list.hpp"

namespace ddssec::cli {

/// What commands add to the lists of CAs. Each CA has a list of its own, renewed.pem beside its
/// certificate: that of an identity CA has certificates, that of a permissions CA permissions. The
/// caller holds the lock of each (OpenCa).
class NewlyListed {
 public:
  void add(const CaPaths& ca, const pki::Certificate& renewed);
  /// Permissions, signed for `file`. Those that name no subject are left out, with a notice:
  /// permissions_unlisted.
  void add(const CaPaths& ca, BytesView signed_permissions, const std::filesystem::path& file);
  /// Adds them to the files. A certificate replaces former ones of its subject, and permissions
  /// replace those that give the same and do not end later. Ended entries leave. A file that
  /// cannot be read is begun anew. If a list has more than is read, older permissions of a subject
  /// that has later ones leave first, and then what ends first. Errors, after the files are
  /// written: renewal_list_malformed (begun anew), file_too_large (something left); those of
  /// FileTransaction.
  Status write(WallTime now) const;

 private:
  std::map<std::filesystem::path, pki::RenewalList> files_;
};

/// The grants in the CA's list that have not ended. None if it cannot be read.
std::vector<governance::Grant> listed_grants(const CaPaths& ca, WallTime now);

/// True if all grants of `next` name their subjects, and one of them gives the same as a former
/// grant of its subject, or more, and ends later.
bool extends(const governance::Permissions& next, const std::vector<governance::Grant>& former);

/// The lists of the CAs in a folder.
struct RenewalsOfCas {
  pki::RenewalList list = {};
  std::vector<pki::Certificate> cas = {};  ///< whose lists were read
  std::set<std::string> revoked = {};      ///< serial numbers of the identity CA
  /// Of the others: those of read_file and RenewalList::parse, with hints for a CA's list.
  std::vector<Error> problems = {};
};
/// The lists of both CAs at `given`, as one. Without certificates that `revoked` names, the present
/// list of the identity CA; null: it has none.
RenewalsOfCas renewals_of(const std::filesystem::path& given, const pki::Crl* revoked);

/// Entries for a participant's folder.
struct RenewalsForFolder {
  const pki::RenewalList& entries;
  const std::vector<pki::Certificate>& cas;  ///< what these issued leaves if it is `revoked`
  const std::set<std::string>& revoked;      ///< serial numbers
  WallTime now;
};

/// Drafts the renewal list of a participant's folder: the entries, and those that are there of
/// CAs that the folder has, as NewlyListed::write adds them. A list that cannot be read is
/// made anew, and one whose entries have all left is emptied. Nothing if the list is there already.
/// A notice (file_too_large) if something was left out. Errors: those of FileTransaction::put.
Status put_renewals(FileTransaction& out, const pki::ParticipantFolder& files,
                    const RenewalsForFolder& what);

/// True if put_renewals can judge permissions: a permissions CA is in the folder. Otherwise it adds
/// none, and those that are there stay.
bool takes_permissions(const pki::ParticipantFolder& files);

}  // namespace ddssec::cli
