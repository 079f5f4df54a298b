// Finds the present folders of a CA's participants. The CA's log contains the absolute paths at
// which the folders were made. A keystore or a CA may have been moved or copied since, with its
// participants or without them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/ca/ca_folder.hpp"

namespace ddssec::cli {

/// Reads the certificate in a participant's folder, for comparison. Another user may own the
/// folder, so only a plain file is opened, and no link that another user can change is followed.
/// Empty if there is no certificate that can be read.
std::optional<pki::Certificate> certificate_of_others(const std::filesystem::path& folder);

/// Translates paths of the log to present paths.
class LoggedFolders {
 public:
  /// Both arguments must outlive it.
  LoggedFolders(const CaPaths& ca, const pki::IssueLog& log);

  /// Returns the present path of a folder in the log. It is beside the CA if the certificate that
  /// the log has for the folder is at the same place there; otherwise it is the path in the log.
  std::filesystem::path today(const std::string& logged) const;

  /// True if another copy of this CA is beside the folder (the keystore from which this one was
  /// copied). That copy's commands write there, and this one's must not.
  bool is_of_another_copy(const std::filesystem::path& folder) const;

  /// True if the folder is in the keystore, or in the folder that contains the CA's folder.
  bool is_inside(const std::filesystem::path& folder) const;

  /// Returns the keystore of the CA; empty if it has none.
  const std::optional<std::filesystem::path>& keystore() const { return keystore_; }

 private:
  bool holds_logged(const std::filesystem::path& folder, const std::string& logged) const;

  const CaPaths& ca_;
  const pki::IssueLog& log_;
  std::filesystem::path root_;
  std::optional<std::filesystem::path> keystore_;
};

/// The participants whose certificates are not revoked.
struct ParticipantPlaces {
  std::vector<std::filesystem::path> here;
  std::vector<std::string> outside;       ///< folders in `here` that are not in the CA's keystore
  std::vector<std::string> unlogged;      ///< folders in `here` that are not in the log
  std::vector<std::string> elsewhere;     ///< in the log, but not on this machine
  std::vector<std::string> left_behind;   ///< here, with a certificate of the CA before a rotation
  std::vector<std::string> of_other_cas;  ///< here, with a certificate that the log does not have
  std::vector<std::string> other_copies;  ///< beside another copy of the CA
  std::vector<Error> unseen = {};         ///< parts of the CA's keystore that were not searched

  /// True if the log contains no participant's folder.
  bool is_empty() const {
    return here.empty() && elsewhere.empty() && other_copies.empty() && left_behind.empty() &&
           of_other_cas.empty();
  }
};

/// Finds all folders in the log. For a keystore's CA, also finds all enclaves, whether they are in
/// the log or not. A folder that cannot be entered counts as `here`. Errors: those of
/// read_certificate for the CA's certificate.
Result<ParticipantPlaces> participant_places(const CaPaths& ca, const pki::IssueLog& log);

/// True if the log has participants with folders and all of them are revoked, so that no folder
/// needs a revocation list.
bool are_all_revoked(const pki::IssueLog& log);

/// Returns the folders on this machine whose certificates are revoked. They get no revocation list
/// unless they are named: peers refuse the participant, whatever list it has. For a keystore's CA,
/// they may be enclaves that are not in the log.
std::vector<std::string> revoked_folders(const CaPaths& ca, const pki::IssueLog& log);

/// Returns lines of text about the result of revoked_folders; empty if there are none.
std::string revoked_folders_text(const std::vector<std::string>& folders);

/// Returns lines of text about all places except `here`, and about copies of folders.
std::string places_text(const ParticipantPlaces& places, const CaPaths& ca);

}  // namespace ddssec::cli
