// Recovery after a command was killed while it put several files in place.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "base/result.hpp"

namespace ddssec::cli {

/// A file that is complete and on the disk, and its final place: `draft` is `target` with an ending
/// of digits and ".new".
struct Draft {
  std::filesystem::path draft, target;
};

/// The places that a list may name.
enum class Reach : std::uint8_t {
  folder,    ///< only files of the folder that contains the list
  anywhere,  ///< also files of other folders: for a CA's own folder, which no participant writes
};

/// A list of drafts in a folder. It is on the disk before the first draft is put in place, and
/// removed after the last one. It remains if the process is killed in between, or cannot put a
/// draft in place.
class PendingRenames {
 public:
  /// Writes a list. First finishes the work that an earlier process left there. Drafts that cannot
  /// be finished yet stay on the list, unless `drafts` has a new version of the file. Errors: those
  /// of finish_interrupted.
  static Result<PendingRenames> write(const std::filesystem::path& folder,
                                      std::span<const Draft> drafts);

  /// True if finish_interrupted() will accept the list.
  bool is_trusted() const;
  /// Leaves the list for the next command.
  void leave_for_next_command() { is_kept_ = true; }

  ~PendingRenames();
  PendingRenames(PendingRenames&& other) noexcept;
  PendingRenames& operator=(PendingRenames&&) = delete;

 private:
  PendingRenames(int folder, int file) : folder_(folder), file_(file) {}
  int folder_;
  int file_;  ///< locked, which shows that this process is alive
  bool is_kept_ = false;
};

/// Puts the drafts in place that a killed process listed in the folder, so that a key and its
/// certificate, or a CA and the documents that it signed, match again. Waits some seconds for a
/// process that is alive. Does nothing in a dry run, or if the folder cannot be read.
///
/// A list is accepted only if this user (or root) wrote it. Folder, list and drafts must belong to
/// that user. The list and the drafts must be regular files without further names, and no other
/// user may be able to write the list or replace it in the folder. The reason is that a
/// participant's folder may belong to another user, or may have come from its device.
///
/// With Reach::anywhere, a file of another folder that cannot be put in place stays on the list and
/// causes a notice (unfinished_left), so that no participant's folder stops the commands of the CA.
/// Errors: unfinished_untrusted, file_unwritable.
Status finish_interrupted(const std::filesystem::path& folder, Reach reach = Reach::folder);

}  // namespace ddssec::cli
