// Opens folders by paths that another user may have a part in: who owns a folder above a
// participant's can put a link in it, to the folder of another participant.
#pragma once

#include <filesystem>

#include "base/file_descriptor.hpp"
#include "base/result.hpp"

namespace ddssec {

/// Opens a folder with `flags` of open(2), besides O_DIRECTORY, O_NOFOLLOW and O_CLOEXEC. The last
/// name of the path must not be a link. A link before it is followed if only root and this user can
/// change it: every folder up to the link belongs to one of them, and no other may write there (but
/// for a user other than root, the folder's group may). In a folder with the sticky bit (/tmp) it
/// suffices that the link itself belongs to one of them. Folders of other users are entered, but no
/// link in or below them is followed. The result is empty if the system refuses, with errno. Error:
/// link_untrusted.
Result<FileDescriptor> open_guarded(const std::filesystem::path& folder, int flags);

}  // namespace ddssec
