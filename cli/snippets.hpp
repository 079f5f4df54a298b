// What an application's configuration must say to use a participant's folder.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "pki/participant_folder.hpp"

namespace ddssec::cli {

/// One file of a participant's folder that a product is started with.
struct ConfigurationFile {
  std::string name;  ///< cyclonedds.xml, fastdds.xml
  std::string text;
};
/// Those of all products. Every command that makes a participant's folder puts them there; ROS 2
/// needs none. They name the files of `folder` by their whole paths, and so the plugin libraries in
/// `dropin`; if that is empty, the loader finds the libraries by their names.
std::array<ConfigurationFile, 2> configuration_files(const pki::ParticipantFolder& folder,
                                                     const std::filesystem::path& dropin = {});
/// Those of them that a folder lacks: a user may have changed those that are there. Given `dropin`,
/// also a cyclonedds.xml that differs in nothing but the libraries. Error: would_overwrite, if it
/// differs in more.
Result<std::vector<ConfigurationFile>> missing_configuration_files(
    const pki::ParticipantFolder& folder, const std::filesystem::path& dropin);
/// Lines for people: the variables that name these files of `folder`, which is `name`'s.
std::string configuration_lines(std::string_view name, const std::filesystem::path& folder);

/// A Cyclone DDS configuration: the value of CYCLONEDDS_URI, or a file that it names.
std::string cyclonedds_snippet(const pki::ParticipantFolder& folder,
                               const std::filesystem::path& dropin = {});

/// A Fast DDS profile file: what FASTRTPS_DEFAULT_PROFILES_FILE names.
std::string fastdds_snippet(const pki::ParticipantFolder& folder);

/// Environment variables of ROS 2 for an enclave of a keystore.
std::string ros2_snippet(const std::filesystem::path& keystore, const std::string& enclave);

}  // namespace ddssec::cli
