// Finds files and folders that users other than root and the participant's own could replace.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <sys/types.h>
#include <vector>

#include "base/finding.hpp"
#include "governance/doctor/diagnosis.hpp"

struct stat;

namespace ddssec::governance::doctor {

/// Collects DOC104: a file or folder that every user of this machine can write (an error), or that
/// belongs to another user or can be written by a group or, by an access control list, by another
/// user (a warning). A group does not count if it is root's, or if it has the name of its owner and
/// no further member.
class WritablePlaces {
 public:
  /// `owner` is the participant's user. It is trusted, as are root and the user of this process.
  explicit WritablePlaces(uid_t owner);

  /// Judges only the file or folder to which `path` leads.
  void add(const std::filesystem::path& path);
  /// Judges the file or folder, all folders above it, and all links on the way (40 at most, as
  /// Linux follows) and the folders above these. In a folder with the sticky bit, such as /tmp, it
  /// suffices that a name belongs to a trusted user.
  void add_with_way(const std::filesystem::path& path);

  /// Returns the findings in the order in which they were found, each once.
  const std::vector<Finding>& findings() const { return findings_; }
  /// Adds the findings to a diagnosis, with this outcome if one of them is an error.
  void report(const Outcomes& if_error, Diagnosis& out) const;

 private:
  void add_way(const std::filesystem::path& path, int& links_left);
  void add_folders_above(const std::filesystem::path& name);
  void diagnose_place(const std::filesystem::path& path, const struct stat& status);
  void diagnose_acl(const std::filesystem::path& path);
  bool is_trusted(uid_t user) const;
  void found(const std::filesystem::path& path, std::string message, Severity severity);

  uid_t owner_;
  std::vector<Finding> findings_;
};

/// Returns the owner of the key, who can do what the participant can. Without a key, returns the
/// owner of the folder.
uid_t user_of(const pki::ParticipantFolder& paths);

/// Checks who can write to further files of the participant's process: libraries of plugins,
/// properties.
void diagnose_files_of_process(const LoadedFolder& folder,
                               std::span<const std::filesystem::path> files, Diagnosis& out);

}  // namespace ddssec::governance::doctor
