// What `doctor` and `check` share.
#pragma once

#include <filesystem>
#include <initializer_list>

#include "cli/command.hpp"
#include "governance/doctor/meeting.hpp"

namespace ddssec::cli {

/// The participant's folder, loaded.
governance::doctor::LoadedFolder load_participant(const std::filesystem::path& folder,
                                                  WallTime now);
/// The domain to look at: what --domain says, else one that the documents of all these folders are
/// for. If there are others, a note in the report says which was taken. Error: usage.
Result<DomainId> domain_for(const Arguments& arguments,
                            std::initializer_list<const governance::doctor::LoadedFolder*> folders,
                            WallTime now, Report& report);
/// What sentences call the folders: their last parts, or the whole paths where those are equal.
void name_parties(const std::filesystem::path& a, const std::filesystem::path& b,
                  std::string (&names)[2]);

}  // namespace ddssec::cli
