// Opens folders by paths that another user can change in part: the owner of a folder above a
// participant's folder can put a link there that leads to the folder of another participant.
#pragma once

#include <filesystem>

#include "base/file_descriptor.hpp"
#include "base/result.hpp"

namespace ddssec {

/// Opens a folder with `flags` of open(2), besides O_DIRECTORY, O_NOFOLLOW and O_CLOEXEC. The last
/// name of the path must not be a link. A link before the last name is followed only if no other
/// user than root and this one can change it: every folder up to the link belongs to one of these
/// two, and no other user may write there. (For a user other than root, the folder's group may
/// write.) In a folder with the sticky bit (/tmp) it suffices that the link itself belongs to one
/// of them. Folders of other users are entered, but no link in or below them is followed. If the
/// system refuses, the result is empty and errno has the reason. Error: link_untrusted.
Result<FileDescriptor> open_guarded(const std::filesystem::path& folder, int flags);

}  // namespace ddssec
