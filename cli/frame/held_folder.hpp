// Folders that stay open from the first read to the last write. Another user may own a
// participant's folder and replace it by a link to another folder meanwhile.
#pragma once

#include <filesystem>
#include <sys/resource.h>

#include "base/result.hpp"
#include "cli/frame/new_file.hpp"

namespace ddssec::cli {

/// Opens a participant's folder and keeps it open until the process ends. From now on commands read
/// and write the files directly in it through its descriptor, wherever the path leads later. Call
/// it before reading the first file whose content decides what is written. A symbolic link in its
/// place is not followed, nor is one in the path that another user can change (guarded_path.hpp).
/// Errors: would_overwrite (a link), link_untrusted, file_unwritable.
Status hold_folder(const std::filesystem::path& folder);

/// Returns the descriptor of a folder, by the path given to hold_folder(). A folder that is not
/// held is opened now, following links, and kept open for writing. On error returns -1, with errno.
int folder_descriptor(const std::filesystem::path& folder);

/// Opens a folder within an open folder, for listing and writing. A symbolic link is not followed.
/// On error the descriptor is -1, with errno.
FileDescriptor open_folder_in(int parent, const std::filesystem::path& name);

/// Lets this process open so many files, if it may raise its limit that far; otherwise as many as
/// it may. Returns true if the limit was raised.
bool allow_open_files(rlim_t files);

/// Returns the path for reading a file directly in a held folder, or for the folder itself. Any
/// other path is returned unchanged. For system calls, not for messages.
std::filesystem::path path_in_held_folder(const std::filesystem::path& path);

/// Keeps the owner of a replaced file, because the participant could not start with a key that only
/// root can read. If root runs the command, the open `file` gets the owner and group of the target
/// in `folder`; if the owner runs it, only the group. A new file that everyone may read gets the
/// owner of the folder. Returns 0. If the owner or group cannot be set, returns errno for a file
/// that must not be readable for everyone, or whose group must be able to read it.
int keep_owner(int file, int folder, const std::filesystem::path& target, unsigned mode);

}  // namespace ddssec::cli
