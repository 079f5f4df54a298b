#include "cli/agent/files_in_place.hpp"

#include <sys/stat.h>

#include "base/tool_code.hpp"
#include "cli/frame/held_folder.hpp"

namespace ddssec::cli {

FilesInPlace::Stamp FilesInPlace::stamp_of(const std::filesystem::path& file) {
  struct stat status {};
  if (::fstatat(folder_descriptor(file.parent_path()), file.filename().c_str(), &status, 0) != 0)
    return std::nullopt;
  const auto number = [](auto value) { return static_cast<std::uint64_t>(value); };
  return {{number(status.st_dev), number(status.st_ino), number(status.st_size),
           number(status.st_mtim.tv_sec), number(status.st_mtim.tv_nsec),
           number(status.st_ctim.tv_sec), number(status.st_ctim.tv_nsec)}};
}

FilesInPlace::FilesInPlace(const std::vector<std::filesystem::path>& files) {
  for (const auto& file : files) files_.emplace_back(file, stamp_of(file));
}

Status FilesInPlace::check_unchanged() const {
  for (const auto& [file, stamp] : files_)
    if (stamp_of(file) != stamp) return fail(tool_code::files_changed, {.document = file});
  return {};
}

}  // namespace ddssec::cli
