// Finds the files of a participant that a configuration names.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "governance/doctor/effective_security.hpp"
#include "governance/doctor/loaded_folder.hpp"

namespace ddssec::governance::doctor {

/// A file of a participant, as configurations call it.
struct Role {
  std::string_view element;   ///< the element of Cyclone DDS's configuration, in lower case
  std::string_view property;  ///< the last part of Fast DDS's property
  std::filesystem::path pki::ParticipantFolder::*judged;
};
inline constexpr Role kRoles[] = {
    {"identityca", "identity_ca", &pki::ParticipantFolder::identity_ca},
    {"identitycertificate", "identity_certificate", &pki::ParticipantFolder::certificate},
    {"privatekey", "private_key", &pki::ParticipantFolder::key},
    {"crl", "identity_crl", &pki::ParticipantFolder::crl},
    {"permissionsca", "permissions_ca", &pki::ParticipantFolder::permissions_ca},
    {"governance", "governance", &pki::ParticipantFolder::governance},
    {"permissions", "permissions", &pki::ParticipantFolder::permissions},
};

/// The value in a configuration for a role.
struct NamedFile {
  const Role* role;
  std::string value;  ///< "file:/a/b", "data:,..." or "pkcs11:..."
};

/// Returns the text with the five predefined entities of XML replaced.
std::string without_escapes(std::string_view text);

/// Returns the values that apply to the domain. If there are none, returns all values that look
/// like them.
std::vector<NamedFile> named_by_cyclonedds(std::string_view text, const EffectiveSecurity& security,
                                           DomainId domain);
/// Returns the paths of those values that name files.
std::vector<std::filesystem::path> paths_of(const std::vector<NamedFile>& named);
/// Returns all values that look like those of a property, in any profile and in a text that is not
/// well-formed.
std::vector<NamedFile> named_anywhere_by_fastdds(std::string_view text);
/// Returns the values of the default profile, of which the last one counts.
std::vector<NamedFile> named_by_fastdds(std::string_view text);

}  // namespace ddssec::governance::doctor
