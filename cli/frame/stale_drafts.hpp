// Removes drafts and unfinished folders that killed commands left.
#pragma once

#include <filesystem>
#include <span>
#include <string>

namespace ddssec::cli {

/// Returns "PID.NAMESPACE" in digits, a part of the name of every draft. With it another process
/// can check whether the process that made the draft is still alive. PIDs are compared only within
/// their namespace.
std::string process_mark();

/// Removes drafts of these files ("NAME.MARK.new", "NAME.MARK.N.new") that an ended process left
/// beside them. Only regular files of this user are removed. Drafts of a process in another
/// namespace are removed when they are one day old. At most 10,000 entries of a folder are checked.
void remove_drafts_of(std::span<const std::filesystem::path> targets);

/// Removes everything in an open folder. Symbolic links are removed, never followed.
void remove_contents(int folder);

/// The same as remove_drafts_of for unfinished folders (".NAME.MARK.XXXXXX") beside `target`, with
/// their contents. Symbolic links are removed, never followed.
void remove_unfinished_folders(const std::filesystem::path& target);

}  // namespace ddssec::cli
