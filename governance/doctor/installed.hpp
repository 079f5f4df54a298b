// Which version of a stock product this machine has.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "governance/doctor/vendor.hpp"

namespace ddssec::governance::doctor {

/// Where the dynamic loader looks: the folders of LD_LIBRARY_PATH, then the system's.
std::vector<std::filesystem::path> library_folders(std::string_view library_path);

/// The version in the name of the product's library (libddsc.so.0.10.2, libfastrtps.so.2.9.1,
/// libfastdds.so.3.1.2) in the first of the folders that has one; the newest there. Nothing is
/// loaded. Nothing if there is none, or for ours.
std::optional<Version> installed_version(Vendor vendor,
                                         const std::vector<std::filesystem::path>& folders);

}  // namespace ddssec::governance::doctor
