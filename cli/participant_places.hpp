// Where the participants of a CA are today. The CA's log has the absolute paths at which their
// folders were made; a keystore or a CA may have been moved or copied since, with them or alone.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/ca_folder.hpp"

namespace ddssec::cli {

/// Translates the log's paths.
class LoggedFolders {
 public:
  /// Both must outlive it.
  LoggedFolders(const CaPaths& ca, const pki::IssueLog& log);

  /// Where a folder of the log is today: beside the CA, if the certificate that the log has for
  /// that folder is in the same place there; else as the log says.
  std::filesystem::path today(const std::string& logged) const;

  /// True if another copy of this CA lies beside the folder (the keystore from which this one was
  /// copied): that copy's commands write there, this one's do not.
  bool is_of_another_copy(const std::filesystem::path& folder) const;

  /// True if the folder lies in the keystore, or in the folder that holds the CA's.
  bool is_inside(const std::filesystem::path& folder) const;

  /// The keystore that the CA belongs to; nothing if it belongs to none.
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
  std::vector<std::string> outside;       ///< those of `here` that are not in the CA's keystore
  std::vector<std::string> unlogged;      ///< those of `here` that the log does not know
  std::vector<std::string> elsewhere;     ///< in the log, not on this machine
  std::vector<std::string> left_behind;   ///< here, with a certificate of the CA before a rotation
  std::vector<std::string> of_other_cas;  ///< here, with a certificate that the log does not have
  std::vector<std::string> other_copies;  ///< beside another copy of the CA
  std::vector<Error> unseen = {};         ///< what of the CA's keystore was not looked at

  /// True if the log knows no participant's folder at all.
  bool is_empty() const {
    return here.empty() && elsewhere.empty() && other_copies.empty() && left_behind.empty() &&
           of_other_cas.empty();
  }
};

/// Every folder of the log, and every enclave of a keystore's CA, logged or not. A folder that may
/// not be entered counts as here. Errors: those of read_certificate, for the CA's.
Result<ParticipantPlaces> participant_places(const CaPaths& ca, const pki::IssueLog& log);

/// Lines for people about all places but `here`, and about copies of folders.
std::string places_text(const ParticipantPlaces& places, const CaPaths& ca);

}  // namespace ddssec::cli
