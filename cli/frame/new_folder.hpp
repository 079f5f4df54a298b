// Makes a folder that appears with all of its files or not at all.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/bytes.hpp"
#include "cli/frame/interruption.hpp"
#include "cli/frame/new_file.hpp"

namespace ddssec::cli {

/// A folder that a command creates. It is built beside its final place, under a temporary name and
/// readable only by the owner. When it is complete and on the disk, one rename gives it its name. A
/// folder that is not committed is removed.
///
/// The parent may belong to another user, who can rename the unfinished folder and put a link or
/// another folder in its place at any time. So everything is written through descriptors, which are
/// opened once and without following links, and a folder that was exchanged is refused.
class NewFolder {
 public:
  /// Begins a folder. Errors: would_overwrite if there is anything (including a dangling link) at
  /// `target`; file_unwritable.
  static Result<NewFolder> at(const std::filesystem::path& target);

  /// Writes a file, created with `mode` and never with more permissions. `name` may contain
  /// folders; only the owner can enter those called "private". Errors: file_unwritable,
  /// interrupted.
  Status add(const std::filesystem::path& name, BytesView octets, unsigned mode);
  Status add_public(const std::filesystem::path& name, std::string_view text) {
    return add(name, as_bytes(text), 0644);
  }
  /// Adds a symbolic link to `to`, which is relative to the link. Errors as add.
  Status link(const std::filesystem::path& name, const std::filesystem::path& to);

  /// Gives the folder its name. Errors: would_overwrite, file_unwritable, interrupted.
  Result<std::vector<WrittenFile>> commit();

  const std::filesystem::path& target() const { return target_; }

  ~NewFolder();
  NewFolder(NewFolder&& other) noexcept = default;
  NewFolder& operator=(NewFolder&&) = delete;

 private:
  /// The unfinished folder.
  struct Staging {
    int parent;        ///< a descriptor that stays open until the process ends
    std::string name;  ///< its name in the parent
    FileDescriptor folder;
    InterruptionGuard drafting = {};
  };
  explicit NewFolder(std::filesystem::path target) : target_(std::move(target)) {}
  static Result<Staging> make_staging(const std::filesystem::path& target);
  Result<FileDescriptor> open_folder_of(const std::filesystem::path& name) const;
  Status create(const std::filesystem::path& name, BytesView octets, unsigned mode);
  Status flush() const;
  Status put_in_place();
  std::filesystem::path target_;
  std::optional<Staging> staging_;  ///< empty once committed, and in a dry run
  std::vector<std::filesystem::path> names_;
  std::vector<WrittenFile> files_;
};

}  // namespace ddssec::cli
