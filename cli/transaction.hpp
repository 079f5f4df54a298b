// Files that appear all at once or not at all, and never in place of others.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/bytes.hpp"
#include "cli/report.hpp"

namespace ddssec::cli {

/// From here on SIGINT, SIGTERM and SIGHUP end the command by the next file with `interrupted`.
void note_interruptions();
/// Error: interrupted.
Status check_not_interrupted();

/// One folder that a command makes. It grows beside its final place, under a name of its own and
/// readable by the owner only, and gets its name by one rename when it is complete; a folder that
/// is not committed is removed. Symbolic links are not followed at the target.
class NewFolder {
 public:
  /// Errors: would_overwrite if there is anything (a dangling link as well) at `target`;
  /// file_unwritable.
  static Result<NewFolder> at(const std::filesystem::path& target);

  /// Writes a file, made with `mode` and never wider. `name` may have folders in it.
  /// Errors: file_unwritable, interrupted.
  Status add(const std::filesystem::path& name, BytesView octets, unsigned mode);
  Status add_public(const std::filesystem::path& name, std::string_view text) {
    return add(name, as_bytes(text), 0644);
  }

  /// Gives the folder its name. Errors: would_overwrite, file_unwritable, interrupted.
  Result<std::vector<WrittenFile>> commit();

  ~NewFolder();
  NewFolder(NewFolder&& other) noexcept;
  NewFolder& operator=(NewFolder&&) = delete;

 private:
  NewFolder(std::filesystem::path target, std::filesystem::path staging)
      : target_(std::move(target)), staging_(std::move(staging)) {}
  std::filesystem::path target_;
  std::filesystem::path staging_;  ///< empty once committed
  std::vector<WrittenFile> files_;
};

/// One new file, complete or not there, never in place of another one.
/// Errors: would_overwrite, file_unwritable, interrupted.
Result<WrittenFile> write_new_file(const std::filesystem::path& target, BytesView octets,
                                   unsigned mode);

}  // namespace ddssec::cli
