// The drop-in folder: contains ddssec's plugin libraries under the names of the stock ones.
#pragma once

#include <filesystem>
#include <string>

#include "cli/frame/command.hpp"

namespace ddssec::cli {

inline constexpr Option kDropIn{
    "--dropin", "DIR",
    "ddssec's plugins where the application runs: cyclonedds.xml names them by whole paths, and "
    "Cyclone DDS does not start without them"};

/// The folder of --dropin, as an absolute path; empty without the option. A folder of another
/// machine need not exist here. Errors: usage for a folder that exists without ddssec's three
/// libraries, for a relative path to no folder, and for a path that Cyclone DDS would read
/// differently.
Result<std::filesystem::path> drop_in_of(const Arguments& arguments);

/// A line of text about a configuration that names the libraries there. For an empty path: about
/// one that names no folder, with which it depends on the environment whose plugins are loaded.
std::string drop_in_line(const std::filesystem::path& dropin);

}  // namespace ddssec::cli
