// Configurations with which an application uses a participant's folder.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "governance/model.hpp"
#include "pki/participant_folder.hpp"

namespace ddssec::cli {

/// A configuration file in a participant's folder, with which a product is started.
struct ConfigurationFile {
  std::string name;  ///< cyclonedds.xml, fastdds.xml
  std::string text;
};
/// Returns the configuration files of all products. Every command that makes a participant's folder
/// writes them there, except for ROS 2, which needs none. They name the files of `folder`, and the
/// plugin libraries in `dropin`, by absolute paths. If `dropin` is empty, the loader finds the
/// libraries by their names.
std::array<ConfigurationFile, 2> configuration_files(const pki::ParticipantFolder& folder,
                                                     const std::filesystem::path& dropin = {});
/// Returns the configuration files that a folder lacks. Existing ones stay, because the user may
/// have changed them. With `dropin`, also returns a cyclonedds.xml that differs only in the
/// libraries. Errors: would_overwrite if it differs in more; those of check_nameable.
Result<std::vector<ConfigurationFile>> missing_configuration_files(
    const pki::ParticipantFolder& folder, const std::filesystem::path& dropin);
/// Returns lines of text with the environment variables that name these files of `folder`, which
/// belongs to the participant `name`.
std::string configuration_lines(std::string_view name, const std::filesystem::path& folder);
/// Returns a line for each file that the participant needs to start and that `identity issue` has
/// not made; empty if all are there.
std::string missing_files_text(const pki::ParticipantFolder& files);
/// True if the folder's cyclonedds.xml names libraries without a path.
bool leaves_libraries_open(const std::filesystem::path& folder);

/// Success if configurations and lines for a shell can name files in the folder: the whole path has
/// no line break, no other control character and nothing that printable() replaces. Error: usage.
Status check_nameable(const std::filesystem::path& folder);

/// Returns a Cyclone DDS configuration, for CYCLONEDDS_URI or a file that it names.
std::string cyclonedds_snippet(const pki::ParticipantFolder& folder,
                               const std::filesystem::path& dropin = {});

/// Returns a Fast DDS profile file, for FASTRTPS_DEFAULT_PROFILES_FILE (Fast DDS 3:
/// FASTDDS_DEFAULT_PROFILES_FILE).
std::string fastdds_snippet(const pki::ParticipantFolder& folder);

/// Returns commands for a shell that start a ROS 2 node in an enclave of a keystore, on Cyclone DDS
/// with ddssec's plugins. `domains` are those of the enclave's documents.
std::string ros2_snippet(const std::filesystem::path& keystore, const std::string& enclave,
                         const std::vector<governance::DomainRange>& domains);

}  // namespace ddssec::cli
