// What `doctor` and `check` share.
#pragma once

#include <filesystem>

#include "cli/command.hpp"
#include "governance/doctor/meeting.hpp"

namespace ddssec::cli {

/// Success if it is a folder. Error: file_not_found.
Status check_folder(const std::filesystem::path& folder);
/// The participant's folder, loaded.
governance::doctor::LoadedFolder load_participant(const std::filesystem::path& folder,
                                                  WallTime now);
/// What sentences call the folders: their last parts, or the whole paths where those are equal.
void name_parties(const std::filesystem::path& a, const std::filesystem::path& b,
                  std::string (&names)[2]);
/// The vendors that --vendor may name, for an error.
inline constexpr std::string_view kVendorWords = "cyclonedds@0.10.2, fastdds@2.9.1 or ours";

}  // namespace ddssec::cli
