#include "base/folder_rights.hpp"

#include <unistd.h>

namespace ddssec {

bool is_of_trusted_owner(const struct stat& status) {
  return status.st_uid == 0 || status.st_uid == ::geteuid();
}

std::optional<OpenFolder> open_folder_above(const std::filesystem::path& folder) {
  for (auto at = folder;; at = at.parent_path()) {
    struct stat status {};
    if (::lstat(at.c_str(), &status) != 0) return OpenFolder{at, {}};
    const bool is_open = others_may_write(status) && !is_sticky(status);
    if (!S_ISDIR(status.st_mode) || !is_of_trusted_owner(status) || is_open)
      return OpenFolder{at, status};
    if (at == at.root_path()) return std::nullopt;
  }
}

}  // namespace ddssec
