#include "base/folder_rights.hpp"

#include <unistd.h>

#include <fmt/format.h>

namespace ddssec {

bool is_of_trusted_owner(const struct stat& status) {
  return status.st_uid == 0 || status.st_uid == ::geteuid();
}

std::optional<std::filesystem::path> open_folder_above(const std::filesystem::path& folder) {
  for (auto at = folder;; at = at.parent_path()) {
    struct stat status {};
    const bool is_closed = ::lstat(at.c_str(), &status) == 0 && S_ISDIR(status.st_mode) &&
                           is_of_trusted_owner(status) &&
                           (!others_may_write(status) || is_sticky(status));
    if (!is_closed) return at;
    if (at == at.root_path()) return std::nullopt;
  }
}

std::string owner_and_mode(const std::filesystem::path& file) {
  struct stat status {};
  if (::lstat(file.c_str(), &status) != 0) return "nothing";
  return fmt::format("user {}, mode {:04o}", status.st_uid, status.st_mode & 07777);
}

}  // namespace ddssec
