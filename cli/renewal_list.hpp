// Renewal lists: those that CAs keep, and those in participants' folders.
#pragma once

#include <filesystem>
#include <map>
#include <vector>

#include "cli/ca_folder.hpp"
#include "cli/transaction.hpp"
#include "pki/crl.hpp"
#include "pki/participant_folder.hpp"
#include "pki/renewal_list.hpp"

namespace ddssec::cli {

/// The entries of a file; none if it does not exist, or is no renewal list: then it is made anew.
/// Errors: those of read_file.
Result<pki::RenewalList> read_renewals(const std::filesystem::path& file);

/// The permissions documents of a list, by what they say of themselves.
struct ListedDocument {
  Bytes file;
  std::vector<std::string> subjects = {};
  WallTime end = {};  ///< of its last grant
};

/// What commands add to the lists of CAs. Each CA has a list of its own, renewed.pem beside its
/// certificate: that of an identity CA has certificates, that of a permissions CA permissions. The
/// caller holds the lock of each (OpenCa).
class NewlyListed {
 public:
  void add(const CaPaths& ca, const pki::Certificate& renewed);
  void add(const CaPaths& ca, BytesView signed_permissions);
  /// Adds them to the files. A certificate replaces former ones of its subject, and permissions
  /// replace those that are for none but their subjects. Entries that have ended leave, and if a
  /// list has more than are read, the first ones. Errors: those of read_file and Replacement.
  Status write(WallTime now) const;

 private:
  std::map<std::filesystem::path, pki::RenewalList> files_;
};

/// The lists of both CAs at `given`, as one. Without certificates that `revoked` names, the present
/// list of the identity CA; null: it has none. Errors: those of read_renewals and Crl::revoked.
Result<pki::RenewalList> renewals_of(const std::filesystem::path& given, const pki::Crl* revoked);

/// Entries for a participant's folder.
struct RenewalsForFolder {
  const pki::RenewalList& entries;
  std::vector<pki::Certificate> cas;  ///< whose entries they are; empty: not known
  WallTime now;
};

/// Drafts the renewal list of a participant's folder: the entries, and those that are there of
/// other CAs that the folder has. If the CAs are not known, what is there leaves only if it is
/// replaced. Nothing if the list is there already. Errors: those of read_renewals and
/// Replacement::put.
Status put_renewals(Replacement& out, const pki::ParticipantFolder& files,
                    const RenewalsForFolder& what);

/// "3 certificates and 1 permissions document".
std::string in_words(const pki::RenewalList& list);

}  // namespace ddssec::cli
