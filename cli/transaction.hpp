// Writes files that appear all at once or not at all. Existing files are replaced only if that is
// the purpose of the command.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/bytes.hpp"
#include "cli/report.hpp"
#include "cli/unfinished.hpp"

namespace ddssec::cli {

/// From now on SIGINT, SIGTERM and SIGHUP end the command at the next file with `interrupted`. If
/// no file follows within 200 ms, the signal itself ends it, unless files are drafted and not yet
/// in place.
void note_interruptions();
/// Success unless a signal came. Error: interrupted.
Status check_not_interrupted();

/// From now on nothing is written (--dry-run): every check is made, and the files that would be
/// written are reported.
void write_nothing();
/// True after write_nothing().
bool writes_nothing();

/// The error file_unwritable for a path, by errno; it reports a missing folder.
std::unexpected<Error> unwritable(const std::filesystem::path& path, int error);
/// Success if there is nothing at the path, not even a dangling link, and its folder exists.
/// Errors: would_overwrite, file_unwritable.
Status check_nothing_at(const std::filesystem::path& path);

/// A folder that a command creates. It is built beside its final place, under a temporary name and
/// readable by the owner only. When it is complete and on the disk, one rename gives it its name. A
/// folder that is not committed is removed. Symbolic links at the target are not followed.
class NewFolder {
 public:
  /// Begins a folder. Errors: would_overwrite if there is anything (including a dangling link) at
  /// `target`; file_unwritable.
  static Result<NewFolder> at(const std::filesystem::path& target);

  /// Writes a file, created with `mode` and never with more permissions. `name` may contain
  /// folders; those called "private" are for the owner only. Errors: file_unwritable, interrupted.
  Status add(const std::filesystem::path& name, BytesView octets, unsigned mode);
  Status add_public(const std::filesystem::path& name, std::string_view text) {
    return add(name, as_bytes(text), 0644);
  }
  /// A symbolic link to `to`, which is relative to the link. Errors as add.
  Status link(const std::filesystem::path& name, const std::filesystem::path& to);

  /// Gives the folder its name. Errors: would_overwrite, file_unwritable, interrupted.
  Result<std::vector<WrittenFile>> commit();

  const std::filesystem::path& target() const { return target_; }

  ~NewFolder();
  NewFolder(NewFolder&& other) noexcept;
  NewFolder& operator=(NewFolder&&) = delete;

 private:
  NewFolder(std::filesystem::path target, std::filesystem::path staging)
      : target_(std::move(target)), staging_(std::move(staging)) {}
  Status make_parent(const std::filesystem::path& name);
  Status flush() const;
  std::filesystem::path target_;
  std::filesystem::path staging_;  ///< empty once committed, and in a dry run
  std::vector<std::filesystem::path> drafts_;
  std::vector<WrittenFile> files_;
};

/// Writes files into existing folders: new ones, and replacements if that is the purpose of the
/// command. All are written beside their places and are on the disk before the first one is
/// renamed. So is a list of them, with which the next command finishes the work of a killed one. A
/// target that is a symbolic link, a folder or a device is refused, so that nothing is written
/// elsewhere.
///
/// Files that are put before begin_folder() belong together: if one cannot be put in place, none
/// is. Files that are put after it belong to one participant's folder, which may be another user's:
/// if that folder cannot be written, other folders still get their files.
class Replacement {
 public:
  /// The reaction to a symbolic link: `replaced` replaces the link itself, never its target.
  enum class Links : std::uint8_t { refused, replaced };
  /// Errors: would_overwrite (not a plain file), file_unwritable, interrupted.
  Status put(const std::filesystem::path& target, BytesView octets, unsigned mode,
             Links links = Links::refused);
  Status put_public(const std::filesystem::path& target, std::string_view text) {
    return put(target, as_bytes(text), 0644);
  }
  /// The following files are for the folder of that name, until the next call.
  void begin_folder(std::string name);
  /// Removes the files that were put since begin_folder().
  void abandon_folder();

  /// Puts everything in place, in the order of the calls. A folder that fails is listed in
  /// failures(); its files stay unchanged. If a rename fails, the drafts and the list stay, so that
  /// the next command can finish. Errors, for files that were put before the first begin_folder():
  /// file_unwritable, interrupted.
  Result<std::vector<WrittenFile>> commit();
  /// The same without a list and without remaining drafts, for files that the next command makes
  /// anew, such as a revocation list for each participant. Errors as commit.
  Result<std::vector<WrittenFile>> commit_each();

  /// A folder whose files could not be put in place, and why.
  struct Failure {
    std::string folder;
    Error error;
  };
  const std::vector<Failure>& failures() const { return failures_; }

  Replacement() = default;
  ~Replacement();
  Replacement(const Replacement&) = delete;
  Replacement& operator=(const Replacement&) = delete;

 private:
  struct Folder {
    std::string name = {};
    std::vector<Draft> drafts = {};  ///< without a path once it is in place
    std::vector<WrittenFile> files = {};
  };

  static Status put_in_place(Folder& folder);
  Result<std::vector<WrittenFile>> put_in_place(Intent* intent);
  std::vector<Draft> all_drafts() const;
  std::vector<Folder> folders_ = {{}};  ///< first what is for no folder
  std::vector<Failure> failures_;
  bool has_drafts_ = false;  ///< a signal must wait for them
};

/// Writes one new file, completely or not at all, and never in place of another one. Errors:
/// would_overwrite, file_unwritable, interrupted.
Result<WrittenFile> write_new_file(const std::filesystem::path& target, BytesView octets,
                                   unsigned mode);

/// Success if write_link can probably make this link. Error: would_overwrite.
Status check_link_place(const std::filesystem::path& target, const std::filesystem::path& to);
/// Creates a symbolic link to `to`. An existing link with the same target is kept, because an
/// interrupted command may have made it. Errors: would_overwrite, file_unwritable, interrupted.
Result<WrittenFile> write_link(const std::filesystem::path& target,
                               const std::filesystem::path& to);

/// Appends whole lines to a text file, created with mode 0644 if it does not exist. They are on the
/// disk when this returns. A last line that an earlier crash cut short is removed first. Safe
/// against other processes that do the same with the same `lock`, a file that only its owner can
/// open: every user who can read the text file could hold a lock on it. Errors: those of
/// FileLock::of, file_unwritable, interrupted.
Status append_lines(const std::filesystem::path& target, std::string_view lines,
                    const std::filesystem::path& lock);

}  // namespace ddssec::cli
