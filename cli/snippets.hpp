// What an application's configuration must say to use a participant's folder.
#pragma once

#include <string>

#include "pki/participant_folder.hpp"

namespace ddssec::cli {

/// A Cyclone DDS configuration: the value of CYCLONEDDS_URI, or a file that it names.
std::string cyclonedds_snippet(const pki::ParticipantFolder& folder);

/// A Fast DDS profile file: what FASTRTPS_DEFAULT_PROFILES_FILE names.
std::string fastdds_snippet(const pki::ParticipantFolder& folder);

/// Environment variables of ROS 2 for an enclave of a keystore.
std::string ros2_snippet(const std::filesystem::path& keystore, const std::string& enclave);

}  // namespace ddssec::cli
