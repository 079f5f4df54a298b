// Folders that stay open from the first look into them to the last write: another user may own a
// participant's folder, and put a link to another folder in its place in the meantime.
#pragma once

#include <filesystem>

#include "base/result.hpp"

namespace ddssec::cli {

/// Opens a participant's folder for as long as the process lives. From here on commands read and
/// write the files directly in it through its descriptor, wherever the path leads later. Called
/// before the first file is read whose content decides what is written. A symbolic link is not
/// followed. Errors: would_overwrite (a link), file_unwritable.
Status hold_folder(const std::filesystem::path& folder);

/// The descriptor of a folder, by its path as hold_folder() got it; one that is not held is opened
/// now, through links, and kept for writing. Error: -1, with errno.
int folder_descriptor(const std::filesystem::path& folder);

/// The path by which to read a file directly in a held folder, or the folder itself; any other path
/// as it is. For system calls, not for messages.
std::filesystem::path as_held(const std::filesystem::path& path);

/// What root writes in place of another user's file stays that user's: a key that only root could
/// read would stop the participant. `file`, which is open, gets the owner and group of the target
/// in `folder`, if root runs the command. Error: the number in errno, for a file that not everybody
/// can read.
int keep_owner(int file, int folder, const std::filesystem::path& target, unsigned mode);

}  // namespace ddssec::cli
