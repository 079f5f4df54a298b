// Tells from owner and mode which users can change a file, or put another one in its place.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <sys/stat.h>

namespace ddssec {

/// True if the file belongs to root or to the user of this process.
bool is_of_trusted_owner(const struct stat& status);

/// True if the group or everyone may write. An access control list that lets others write sets the
/// group's bit, too.
inline bool others_may_write(const struct stat& status) { return (status.st_mode & 022) != 0; }

/// True for a folder in which only the owner of a file, of the folder, and root can replace the
/// file.
inline bool is_sticky(const struct stat& status) { return (status.st_mode & S_ISVTX) != 0; }

/// Returns the first folder, from `folder` upwards to the root, in which a user other than root and
/// this process's can replace a file or folder. A sticky folder counts as closed: a file of root or
/// of this user in it is safe, but others can make new files. `folder` must be absolute, and
/// without symbolic links.
std::optional<std::filesystem::path> open_folder_above(const std::filesystem::path& folder);

/// Returns a text for messages, such as "user 1000, mode 0775". It says "nothing" if there is no
/// such file.
std::string owner_and_mode(const std::filesystem::path& file);

}  // namespace ddssec
