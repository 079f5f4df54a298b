// Suggestions for a path at which there is nothing.
#pragma once

#include <filesystem>
#include <string>

namespace ddssec::cli {

/// Returns the path without a slash at its end.
std::filesystem::path without_slash(const std::filesystem::path& path);

/// Returns a possible error in the path of a missing file: its folder does not exist, or its name
/// is similar to that of another file. Empty if neither.
std::string missing_path_hint(const std::filesystem::path& missing);

}  // namespace ddssec::cli
