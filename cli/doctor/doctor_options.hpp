// Functions that `doctor` and `check` share.
#pragma once

#include <filesystem>
#include <initializer_list>

#include "cli/frame/command.hpp"
#include "governance/doctor/meeting.hpp"

namespace ddssec::cli {

/// Loads the participant's folder. An encrypted key is opened with the password that the files
/// give.
governance::doctor::LoadedFolder load_participant(const std::filesystem::path& folder,
                                                  WallTime now);
/// Returns the domain to check: the value of --domain, or else one that the documents of all these
/// folders cover. If there are others, a note in the report names the chosen one. Error: usage.
Result<DomainId> domain_for(const Arguments& arguments,
                            std::initializer_list<const governance::doctor::LoadedFolder*> folders,
                            WallTime now, Report& report);
/// Sets the names of the folders in messages: their last parts, or the whole paths if those are
/// equal.
void name_parties(const std::filesystem::path& a, const std::filesystem::path& b,
                  std::string (&names)[2]);

}  // namespace ddssec::cli
