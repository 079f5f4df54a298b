// Files that appear all at once or not at all, and never in place of others unless that is what the
// command is for.
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

/// From here on SIGINT, SIGTERM and SIGHUP end the command by the next file with `interrupted`;
/// after 200 ms without one, by the signal itself, unless files are drafted and not in place.
void note_interruptions();
/// Error: interrupted.
Status check_not_interrupted();

/// From here on nothing is written: every check is made, and what would have been written is told
/// (--dry-run).
void write_nothing();
/// True after write_nothing().
bool writes_nothing();

/// The error for a path that cannot be written, by its errno: file_unwritable, which says so where
/// the folder for it is missing.
std::unexpected<Error> unwritable(const std::filesystem::path& path, int error);
/// Success if there is nothing at the path, not even a dangling link, and a folder for it. Errors:
/// would_overwrite, file_unwritable.
Status check_nothing_at(const std::filesystem::path& path);

/// One folder that a command makes. It grows beside its final place, under a name of its own and
/// readable by the owner only, and gets its name by one rename when it is complete and on the disk;
/// a folder that is not committed is removed. Symbolic links are not followed at the target.
class NewFolder {
 public:
  /// Errors: would_overwrite if there is anything (a dangling link as well) at `target`;
  /// file_unwritable.
  static Result<NewFolder> at(const std::filesystem::path& target);

  /// Writes a file, made with `mode` and never wider. `name` may have folders in it; those called
  /// "private" are for the owner only. Errors: file_unwritable, interrupted.
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

/// Files in folders that exist: new ones, and newer ones in place of older ones where a command
/// is there to replace them. All are written beside their places and on the disk before the first
/// is renamed; a list of them is, too, so that the next command finishes what a killed one began. A
/// target that is a symbolic link, a folder or a device is refused, so that nothing is written
/// elsewhere.
///
/// What is put before begin_folder() belongs together: if it cannot be put in place, nothing is.
/// What is put after it belongs to one participant's folder, which may be another user's: a folder
/// that cannot be written keeps no other one from its files.
class Replacement {
 public:
  /// What is done where a symbolic link is: the link itself is replaced, never what it leads to.
  enum class Links : std::uint8_t { refused, replaced };
  /// Errors: would_overwrite (not a plain file), file_unwritable, interrupted.
  Status put(const std::filesystem::path& target, BytesView octets, unsigned mode,
             Links links = Links::refused);
  Status put_public(const std::filesystem::path& target, std::string_view text) {
    return put(target, as_bytes(text), 0644);
  }
  /// From here on everything is for the folder of that name, up to the next call.
  void begin_folder(std::string name);
  /// Takes back what was put since begin_folder().
  void abandon_folder();

  /// Puts everything in its place, in the order of the calls. A folder that fails is in failures();
  /// its files stay as they are. If a rename fails, the drafts and the list stay, so that the next
  /// command can finish. Errors, for what was put before the first begin_folder(): file_unwritable,
  /// interrupted.
  Result<std::vector<WrittenFile>> commit();
  /// The same without a list and without drafts that stay, for files that the next command makes
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

/// One new file, complete or not there, never in place of another one.
/// Errors: would_overwrite, file_unwritable, interrupted.
Result<WrittenFile> write_new_file(const std::filesystem::path& target, BytesView octets,
                                   unsigned mode);

/// Whether write_link can make this link, as far as that can be seen. Error: would_overwrite.
Status check_link_place(const std::filesystem::path& target, const std::filesystem::path& to);
/// A symbolic link to `to`. One that is there and leads to the same place is kept: a command that
/// was ended has made it. Errors: would_overwrite, file_unwritable, interrupted.
Result<WrittenFile> write_link(const std::filesystem::path& target,
                               const std::filesystem::path& to);

/// Adds whole lines to a text file, made with mode 0644 if it is not there. They are on the disk
/// when this returns; a last line that an earlier crash cut short is removed first. Safe against
/// other processes that do the same with the same `lock`, a file that only its owner can open:
/// every user who can read the text could hold a lock on it. Errors: those of FileLock::of,
/// file_unwritable, interrupted.
Status append_lines(const std::filesystem::path& target, std::string_view lines,
                    const std::filesystem::path& lock);

}  // namespace ddssec::cli
