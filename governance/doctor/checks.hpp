// The parts of diagnose(). For governance/doctor/ only.
#pragma once

#include <filesystem>
#include <string>

#include "governance/doctor/diagnosis.hpp"

namespace ddssec::governance::doctor {

using ddssec::to_string;

/// As messages name a file of a participant's folder.
inline std::string name_of(const std::filesystem::path& path) { return path.filename().string(); }

/// What a hint says of the permissions of a ROS 2 enclave, which come from a policy; empty for a
/// participant that is none.
inline std::string remedy_of_ros(const LoadedFolder& folder) {
  if (folder.paths.layout != pki::FolderLayout::sros2) return {};
  return "add it to the policy, then ddssec keystore permission KEYSTORE ENCLAVE --policy FILE "
         "--node-defaults";
}

/// Both files can be read and hold the same.
bool has_same_octets(const std::filesystem::path& one, const std::filesystem::path& other);

/// Files there, of the right kind, closed to others.
void check_files(const LoadedFolder& folder, const Settings& settings, Diagnosis& out);
/// The configurations beside them: whether a process that starts with them reads the files that
/// were judged, and is secured.
void check_configurations(const LoadedFolder& folder, const Settings& settings, Diagnosis& out);
/// Certificate, key, CA, revocation.
void check_identity(const LoadedFolder& folder, const Settings& settings, Diagnosis& out);
/// Form, signature and signer of both documents, and whether they can be read.
void check_documents(const LoadedFolder& folder, const Settings& settings, Diagnosis& out);
/// What the documents say about this participant in the domain.
void check_rights(const LoadedFolder& folder, const Settings& settings, Diagnosis& out);
/// What ends first.
void check_ends(const LoadedFolder& folder, const Settings& settings, Diagnosis& out);

/// What governs the participant: the grant that ours would take, or nullptr.
const Grant* grant_of(const LoadedFolder& folder, WallTime now);

/// What to do where something begins after now: a clock that is behind is the usual reason.
std::string clock_hint(WallTime now);
/// The same if `begin` is after now; else nothing, and the rule's own hint counts.
std::string hint_if_early(WallTime begin, WallTime now);

}  // namespace ddssec::governance::doctor
