// Finds the version of a stock product that is installed on this machine.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "governance/doctor/product.hpp"

namespace ddssec::governance::doctor {

/// Returns the folders that the dynamic loader searches: those of LD_LIBRARY_PATH, then the
/// system's.
std::vector<std::filesystem::path> library_folders(std::string_view library_path);

/// Returns the version in the name of the product's library (libddsc.so.0.10.2,
/// libfastrtps.so.2.9.1, libfastdds.so.3.1.2), from the first folder that has one, and the newest
/// there. Nothing is loaded. Empty if there is none, or for ddssec.
std::optional<Version> installed_version(Product product,
                                         const std::vector<std::filesystem::path>& folders);

}  // namespace ddssec::governance::doctor
