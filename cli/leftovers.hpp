// Drafts and unfinished folders of commands that were killed.
#pragma once

#include <filesystem>
#include <span>
#include <string>

namespace ddssec::cli {

/// "PID.NAMESPACE" in digits: stands in the name of every draft, so that another process can tell
/// whether the one that made it still lives. PIDs are compared only within their namespace.
std::string process_mark();

/// Removes drafts of these files ("NAME.MARK.new", "NAME.MARK.N.new") that a process which is gone
/// left beside them. Only plain files of this user; what a process of another namespace left is
/// removed when it is a day old. At most 10,000 entries of a folder are looked at.
void remove_drafts_of(std::span<const std::filesystem::path> targets);

/// The same for unfinished folders (".NAME.MARK.XXXXXX") beside `target`, with all that is in them;
/// symbolic links are removed, never followed.
void remove_unfinished_folders(const std::filesystem::path& target);

}  // namespace ddssec::cli
