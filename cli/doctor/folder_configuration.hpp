// What an application would be configured with, by the files of a folder and the environment.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "pki/participant_folder.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::cli {

/// Returns the path of Cyclone DDS's configuration in a folder, whether it exists or not.
std::filesystem::path configuration_in(const std::filesystem::path& folder);

/// Returns the configuration with which an application of Cyclone DDS would run, as far as it is
/// known: the one that the environment names, or else the one in the folder.
std::optional<std::string> configuration_for(const std::filesystem::path& folder);

/// Returns the properties of the folder's `security.properties`. A file that cannot be read counts
/// as empty; DOC093 reports it.
spi::PropertyList readable_properties(const pki::ParticipantFolder& files);

}  // namespace ddssec::cli
