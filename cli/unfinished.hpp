// What a command that is killed while it puts several files in place leaves to the next one.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "base/result.hpp"

namespace ddssec::cli {

/// A file that is complete and on the disk, and the place it is for: `draft` is `target` with an
/// ending of digits and ".new".
struct Draft {
  std::filesystem::path draft, target;
};

/// Which places a list may name.
enum class Reach : std::uint8_t {
  folder,    ///< only files of the folder in which the list lies
  anywhere,  ///< also files of other folders: for a CA's own folder, which no participant writes
};

/// A list of drafts in a folder, on the disk before the first of them is put in place and gone
/// after the last. A process that is killed in between leaves it, and so does one that cannot put a
/// draft in place.
class Intent {
 public:
  /// Finishes what an earlier process left there first. What cannot be finished yet stays on the
  /// list, except for files that `drafts` has anew. Errors: those of finish_interrupted.
  static Result<Intent> write(const std::filesystem::path& folder, std::span<const Draft> drafts);

  /// True if finish_interrupted() will believe the list.
  bool is_believed() const;
  /// Leaves the list for the next command.
  void keep() { is_kept_ = true; }

  ~Intent();
  Intent(Intent&& other) noexcept;
  Intent& operator=(Intent&&) = delete;

 private:
  Intent(int folder, int file) : folder_(folder), file_(file) {}
  int folder_;
  int file_;  ///< locked, so that others see that this process lives
  bool is_kept_ = false;
};

/// Puts the drafts in place that a killed process listed in the folder, so that a key and its
/// certificate, or a CA and what it signed, fit each other again. Waits some seconds for a process
/// that is alive. Nothing in a dry run, and where the folder may not be read.
///
/// A list is believed only if this user (or root) wrote it: folder, list and drafts are theirs,
/// the list and the drafts are plain files without further names, and no other user may write the
/// list or replace it in the folder. A participant's folder may be another user's, or have come
/// from its device. With Reach::anywhere a file of another folder that cannot be put in place stays
/// on the list and is a notice (unfinished_left): no participant's folder stops the commands of the
/// CA. Errors: unfinished_untrusted, file_unwritable.
Status finish_interrupted(const std::filesystem::path& folder, Reach reach = Reach::folder);

}  // namespace ddssec::cli
