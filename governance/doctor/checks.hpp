// The parts of diagnose(). For governance/doctor/ only.
#pragma once

#include <filesystem>
#include <string>

#include "governance/doctor/diagnosis.hpp"

namespace ddssec::governance::doctor {

using ddssec::to_string;

/// Returns the name of a file of a participant's folder in messages.
inline std::string name_of(const std::filesystem::path& path) { return path.filename().string(); }

/// Returns the hint about the permissions of a ROS 2 enclave, which come from a policy. Empty for
/// other participants.
inline std::string remedy_of_ros(const LoadedFolder& folder) {
  if (folder.paths.layout != pki::FolderLayout::sros2) return {};
  return "add it to the policy, then ddssec keystore permission KEYSTORE ENCLAVE --policy FILE "
         "--node-defaults";
}

/// True if both files can be read and have the same content.
bool has_same_octets(const std::filesystem::path& one, const std::filesystem::path& other);

/// Returns the outcomes with a key that DDS-Security does not allow: that of the certificate or CA
/// at `path`, which ddssec refused with `error`.
Outcomes outcomes_of_key(const pki::ParticipantFolder& paths, const std::filesystem::path& path,
                         const Error& error, const Lineup& lineup);

/// Checks that the files exist, are of the right kind and are not accessible for other users.
void diagnose_files(const LoadedFolder& folder, const Settings& settings, Diagnosis& out);
/// Checks the configuration files in the folder: whether a process that starts with them reads the
/// checked files and uses security.
void diagnose_configurations(const LoadedFolder& folder, const Settings& settings, Diagnosis& out);
/// Checks certificate, key, CA and revocation.
void diagnose_identity(const LoadedFolder& folder, const Settings& settings, Diagnosis& out);
/// Checks form, signature and signer of both documents, and whether they can be parsed.
void diagnose_documents(const LoadedFolder& folder, const Settings& settings, Diagnosis& out);
/// Checks the governance document's rule for the domain, and returns it; returns nullptr if there
/// is none (a part of diagnose_rights).
const DomainRule* diagnosed_domain_rule(const LoadedFolder& folder, const Settings& settings,
                                        Diagnosis& out);
/// Checks the rights of this participant in the domain.
void diagnose_rights(const LoadedFolder& folder, const Settings& settings, Diagnosis& out);
/// Checks what the deny_rules of a grant, and its rules for other domains, mean to stock products,
/// topic by topic (a part of diagnose_rights).
void diagnose_denials(const LoadedFolder& folder, const Settings& settings, const Grant& grant,
                      Diagnosis& out);
/// Checks which part expires first.
void diagnose_ends(const LoadedFolder& folder, const Settings& settings, Diagnosis& out);

/// Returns the grant that ddssec's plugins would apply to the participant, or nullptr.
const Grant* grant_of(const LoadedFolder& folder, WallTime now);

/// Returns the hint for something that begins after `now`: the usual reason is a clock that is
/// slow.
std::string clock_hint(WallTime now);
/// Returns the same if `begin` is after `now`; otherwise empty, so that the rule's own hint counts.
std::string hint_if_early(WallTime begin, WallTime now);

}  // namespace ddssec::governance::doctor
