// Renewal lists: those that CAs keep, and those in participants' folders.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <vector>

#include "cli/ca_folder.hpp"
#include "cli/transaction.hpp"
#include "governance/model.hpp"
#include "pki/crl.hpp"
#include "pki/participant_folder.hpp"
#include "pki/renewal_list.hpp"

namespace ddssec::cli {

/// The permissions documents of a list, by what they say of themselves.
struct ListedDocument {
  Bytes file;
  std::vector<governance::Grant> grants = {};
  WallTime begin = {}, end = {};  ///< of its last grant
};

/// What commands add to the lists of CAs. Each CA has a list of its own, renewed.pem beside its
/// certificate: that of an identity CA has certificates, that of a permissions CA permissions. The
/// caller holds the lock of each (OpenCa).
class NewlyListed {
 public:
  void add(const CaPaths& ca, const pki::Certificate& renewed);
  void add(const CaPaths& ca, BytesView signed_permissions);
  /// Adds them to the files. A certificate replaces former ones of its subject, and permissions
  /// replace those that are for none but their subjects and say nothing of other domains, and do
  /// not begin later. Certificates that have ended leave; permissions stay, since former ones must
  /// not count again. If a list has more than is read, permissions that have ended leave first, and
  /// then the first entries. A file that cannot be read stays as it is. Errors, after the other
  /// files are written: those of read_file, RenewalList::parse and Replacement; file_too_large, if
  /// permissions that have not ended were left out.
  Status write(WallTime now) const;

 private:
  std::map<std::filesystem::path, pki::RenewalList> files_;
};

/// Permissions that are to be signed again.
struct PermissionsAgain {
  const pki::Certificate& certificate;  ///< the participant's
  BytesView text;
  std::optional<WallTime> signed_at;  ///< empty: not known
  const std::filesystem::path& file;
};

/// Success if the CA's list has no later permissions for the subject that give other rights in a
/// domain that they are about: else the list would give back what it took away. Errors:
/// document_superseded, those of read_file and RenewalList::parse.
Status check_not_replaced(const CaPaths& ca, const PermissionsAgain& again);

/// The lists of both CAs at `given`, as one. Without certificates that `revoked` names, the present
/// list of the identity CA; null: it has none. Errors: those of read_file, RenewalList::parse and
/// Crl::revoked.
Result<pki::RenewalList> renewals_of(const std::filesystem::path& given, const pki::Crl* revoked);

/// Entries for a participant's folder.
struct RenewalsForFolder {
  const pki::RenewalList& entries;
  std::vector<pki::Certificate> cas;  ///< whose entries they are; empty: not known
  WallTime now;
};

/// Drafts the renewal list of a participant's folder: the entries, and those that are there of
/// other CAs that the folder has. Permissions that are there leave only if they are replaced; so do
/// certificates if the CAs are not known. A list that cannot be read is made anew. Nothing if the
/// list is there already. Errors: those of Replacement::put.
Status put_renewals(Replacement& out, const pki::ParticipantFolder& files,
                    const RenewalsForFolder& what);

/// "3 certificates and 1 permissions document".
std::string in_words(const pki::RenewalList& list);

}  // namespace ddssec::cli
