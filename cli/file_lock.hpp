// Locks that commands wait for: a bounded time, since another user may hold one for ever.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <utility>
#include <vector>

#include "base/result.hpp"

namespace ddssec::cli {

/// How long a command waits for another one that reads and then writes a CA's files.
inline constexpr std::chrono::seconds kLockPatience{20};

/// Locks an open file (flock) for this process alone, or waits so long for it. `path` is for
/// messages. Errors: file_unwritable, which names the process that holds the lock where /proc/locks
/// tells it; interrupted.
Status lock_file(int file, const std::filesystem::path& path, std::chrono::seconds patience);

/// Keeps other commands that ask for the same file waiting while it lives, so that what one reads
/// and then writes anew cannot lose what another wrote in between. A command that has the lock of a
/// file may take it again.
class FileLock {
 public:
  /// Of a file that only its owner should be able to open, since everybody who can may hold the
  /// lock. Links are followed; a file that was replaced during the wait is locked in its new form.
  /// Errors as lock_file.
  static Result<FileLock> of(const std::filesystem::path& path);

 private:
  /// An open file that closes itself, which ends its lock.
  class Held;
  explicit FileLock(std::shared_ptr<Held> held) : held_(std::move(held)) {}
  static std::vector<std::weak_ptr<Held>>& all();
  std::shared_ptr<Held> held_;
};

}  // namespace ddssec::cli
