// Writes files into existing folders, all at once or not at all. Existing files are replaced only
// if that is the purpose of the command.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/bytes.hpp"
#include "cli/frame/interruption.hpp"
#include "cli/frame/new_file.hpp"
#include "cli/frame/rename_recovery.hpp"
#include "cli/frame/report.hpp"

namespace ddssec::cli {

/// Writes files into existing folders: new ones, and replacements if that is the purpose of the
/// command. All files are written beside their places and are on the disk before the first one is
/// renamed. A list of them is on the disk too, with which the next command finishes the work of a
/// killed one. A target that is a symbolic link, a folder or a device is refused, so that nothing
/// is written elsewhere.
///
/// Files that are put before begin_folder() belong together: if one cannot be put in place, none
/// is. Files that are put after it belong to one participant's folder, which may belong to another
/// user: if that folder cannot be written, other folders still get their files.
class FileTransaction {
 public:
  /// The reaction to a symbolic link: `replaced` replaces the link itself, never its target.
  enum class Links : std::uint8_t { refused, replaced };
  /// Drafts a file for `target`. Errors: would_overwrite (not a plain file), file_unwritable,
  /// interrupted.
  Status put(const std::filesystem::path& target, BytesView octets, unsigned mode,
             Links links = Links::refused);
  Status put_public(const std::filesystem::path& target, std::string_view text) {
    return put(target, as_bytes(text), 0644);
  }
  /// Begins the files of the folder with that name. It gets all files until the next call.
  void begin_folder(std::string name);
  /// Removes the files that were put since begin_folder().
  void abandon_folder();

  /// Puts everything in place, in the order of the calls. A folder that fails is listed in
  /// failures(); its files stay unchanged. If a rename fails, the drafts and the list stay, so that
  /// the next command can finish. Errors, for files that were put before the first begin_folder():
  /// file_unwritable, interrupted.
  Result<std::vector<WrittenFile>> commit();
  /// As commit, without a list and without leaving drafts. Use it for files that the next command
  /// makes again, such as a revocation list for each participant. Errors as commit.
  Result<std::vector<WrittenFile>> commit_each();

  /// A folder whose files could not be put in place, and why.
  struct Failure {
    std::string folder;
    Error error;
  };
  const std::vector<Failure>& failures() const { return failures_; }

  FileTransaction() = default;
  ~FileTransaction();
  FileTransaction(const FileTransaction&) = delete;
  FileTransaction& operator=(const FileTransaction&) = delete;

 private:
  struct Folder {
    std::string name = {};
    std::vector<Draft> drafts = {};  ///< the draft's path is empty once the file is in place
    std::vector<WrittenFile> files = {};
  };

  static Status put_in_place(Folder& folder);
  Result<std::vector<WrittenFile>> put_in_place(PendingRenames* pending);
  std::vector<Draft> all_drafts() const;
  std::vector<Folder> folders_ = {{}};  ///< the first one has the files that belong to no folder
  std::vector<Failure> failures_;
  std::optional<InterruptionGuard> drafting_;  ///< set once there are drafts
};

/// Writes one new file, completely or not at all, and never in place of another one. Errors:
/// would_overwrite, file_unwritable, interrupted.
Result<WrittenFile> write_new_file(const std::filesystem::path& target, BytesView octets,
                                   unsigned mode);

/// Success if write_link will probably be able to make this link. Error: would_overwrite.
Status check_link_place(const std::filesystem::path& target, const std::filesystem::path& to);
/// Creates a symbolic link to `to`. An existing link with the same target is kept, because an
/// interrupted command may have made it. Errors: would_overwrite, file_unwritable, interrupted.
Result<WrittenFile> write_link(const std::filesystem::path& target,
                               const std::filesystem::path& to);

/// Appends whole lines to a log of JSON objects. Creates it with mode 0644 if it does not exist.
/// The lines are on the disk when this returns. An incomplete last line, which an earlier crash
/// left, is removed first; a complete one without a line break gets one. Safe against other
/// processes that do the same with the same `lock`. That is a file that only its owner can open,
/// because every user who can read the log could hold a lock on the log itself. Errors: those of
/// FileLock::of, file_unwritable, interrupted.
Status append_lines(const std::filesystem::path& target, std::string_view lines,
                    const std::filesystem::path& lock);

}  // namespace ddssec::cli
