// Locks for which commands wait only a limited time, because another user may hold one forever.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <utility>
#include <vector>

#include "base/result.hpp"

namespace ddssec::cli {

/// How long a command waits for another one that reads and then writes a CA's files.
inline constexpr std::chrono::seconds kLockTimeout{20};

/// Locks an open file (flock) exclusively for this process; waits at most `timeout`. `path` is for
/// messages. Errors: file_unwritable, with the process that holds the lock if /proc/locks names it;
/// interrupted.
Status lock_file(int file, const std::filesystem::path& path, std::chrono::seconds timeout);

/// A lock on a file. As long as it lives, other commands that lock the same file wait. Thus no
/// change of another command is lost between reading and rewriting. A command that holds the lock
/// of a file may take it again.
class FileLock {
 public:
  /// Locks a file. Only its owner should be able to open it, because every user who can open it can
  /// hold the lock. Links are followed. If the file is replaced during the wait, the new file is
  /// locked. Errors as lock_file.
  static Result<FileLock> of(const std::filesystem::path& path);

 private:
  /// An open file that closes itself, which ends its lock.
  class HeldFile;
  explicit FileLock(std::shared_ptr<HeldFile> held) : held_(std::move(held)) {}
  static std::vector<std::weak_ptr<HeldFile>>& all();
  std::shared_ptr<HeldFile> held_;
};

}  // namespace ddssec::cli
