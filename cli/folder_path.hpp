// Opens a folder by a path that only trusted users can lead elsewhere.
#pragma once

#include <filesystem>

#include "cli/new_file.hpp"

namespace ddssec::cli {

/// A folder, or why it is not open.
struct OpenedFolder {
  Descriptor folder = Descriptor();
  int error = 0;                            ///< errno; ELOOP for a link at the end of the path
  std::filesystem::path foreign_link = {};  ///< a link in the path that is not followed
};

/// Opens a folder with `flags` besides O_DIRECTORY, O_NOFOLLOW and O_CLOEXEC. A link at the end of
/// the path is not followed. A link before it is followed only if it is root's or the running
/// user's, in a folder of root or that user in which no other user can replace it: else the owner
/// of a folder in the path could lead the command to another user's folder.
OpenedFolder open_folder_by_path(const std::filesystem::path& path, int flags);
/// The error folder_untrusted for such a link.
std::unexpected<Error> foreign_link(const std::filesystem::path& folder,
                                    const std::filesystem::path& link);

}  // namespace ddssec::cli
