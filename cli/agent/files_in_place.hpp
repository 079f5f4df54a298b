// Notices that files change while the agent waits for their successors.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include "base/result.hpp"

namespace ddssec::cli {

/// The files that a decision is based on. A hook may take long, and meanwhile another program may
/// put other files into the folder: a key and its certificate, or permissions with fewer rights.
class FilesInPlace {
 public:
  /// Notes which files are there. Call this before they are read.
  explicit FilesInPlace(const std::vector<std::filesystem::path>& files);

  /// Success if they are still the same and were not written. Error: files_changed.
  Status check_unchanged() const;

 private:
  /// Device, inode, size, and seconds and nanoseconds of the last change to the content and to the
  /// inode. Empty if there is no file.
  using Stamp = std::optional<std::array<std::uint64_t, 7>>;
  static Stamp stamp_of(const std::filesystem::path& file);
  std::vector<std::pair<std::filesystem::path, Stamp>> files_;
};

}  // namespace ddssec::cli
