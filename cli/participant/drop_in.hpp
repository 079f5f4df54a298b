// The drop-in folder, which contains ddssec's plugin libraries under the names of the stock ones.
#pragma once

#include <filesystem>
#include <string>

#include "cli/frame/command.hpp"

namespace ddssec::cli {

inline constexpr Option kDropIn{
    "--dropin", "DIR",
    "ddssec's plugins where the application runs: cyclonedds.xml names them by whole paths, and "
    "Cyclone DDS does not start without them"};

/// Returns the folder of --dropin as an absolute path; empty without the option. The folder need
/// not exist here, because it may be on another machine. Errors: usage for a folder that exists
/// without ddssec's three libraries, for a relative path without a folder, and for a path that
/// Cyclone DDS would read differently.
Result<std::filesystem::path> drop_in_of(const Arguments& arguments);

/// Returns a line of text about a configuration that names the libraries in that folder. An empty
/// path stands for a configuration that names no folder, so that the environment decides which
/// plugins are loaded.
std::string drop_in_line(const std::filesystem::path& dropin);

}  // namespace ddssec::cli
