// A participant's folder as the agent uses it. The agent may run as root while the folder belongs
// to another user. The process that reads and writes the folder therefore becomes that user for
// good.
#pragma once

#include <filesystem>
#include <sys/stat.h>
#include <sys/types.h>

#include "base/result.hpp"

namespace ddssec::cli {

/// The user and the group of a folder.
struct FolderOwner {
  uid_t user;
  gid_t group;
};

/// Success for an open folder of this user (for root: of any user) in which only its owner may
/// write. Errors: folder_untrusted; file_unreadable.
Result<FolderOwner> check_folder(int descriptor, const std::filesystem::path& folder);

/// If root runs this process, gives up its rights for those of the owner, with the owner's groups.
/// It cannot get them back. Does nothing for a folder that belongs to root. Error: internal.
Status switch_to_owner(const FolderOwner& owner);

/// The identity of a folder that the agent locked, for processes that open it by its path again.
struct LockedFolder {
  FolderOwner owner;
  dev_t device = 0;
  ino_t inode = 0;

  bool is_same(const struct stat& other) const;
  /// Success if this open folder is the locked one and still has the same owner. The path may lead
  /// to another folder by now. Error: folder_untrusted.
  Status check_same(int descriptor, const std::filesystem::path& folder) const;
};

/// Shows other agents that this one keeps a folder, by a locked file in it that only the agent's
/// user can open. The destructor removes the file. If the process is killed, the file stays but its
/// lock ends.
class FolderLock {
 public:
  /// Locks the folder. Errors: those of check_folder and open_guarded; file_unreadable,
  /// file_unwritable; agent_is_running.
  static Result<FolderLock> acquire(const std::filesystem::path& folder);

  /// False after the folder or the file in it was removed or replaced, or the owner was changed.
  bool is_in_place(const std::filesystem::path& folder) const;
  /// Returns the descriptor of the open file. A process that inherits it keeps the lock.
  int descriptor() const { return file_; }
  const LockedFolder& folder() const { return locked_; }
  const FolderOwner& owner() const { return locked_.owner; }

  ~FolderLock();
  FolderLock(FolderLock&& other) noexcept;
  FolderLock& operator=(FolderLock&& other) noexcept;

 private:
  FolderLock(int folder, int file) : folder_(folder), file_(file) {}
  int folder_;
  int file_;
  LockedFolder locked_ = {};
};

}  // namespace ddssec::cli
