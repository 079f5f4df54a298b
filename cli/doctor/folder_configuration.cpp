#include "cli/doctor/folder_configuration.hpp"

#include "cli/inputs/files.hpp"
#include "governance/doctor/cyclonedds_configuration.hpp"
#include "plugins/spi/property_file.hpp"

namespace ddssec::cli {

namespace doctor = governance::doctor;
namespace fs = std::filesystem;

fs::path configuration_in(const fs::path& folder) { return folder / "cyclonedds.xml"; }

std::optional<std::string> configuration_for(const fs::path& folder) {
  if (auto named = doctor::cyclonedds_configuration()) return named;
  const auto file = configuration_in(folder);
  return path_exists(file) ? doctor::cyclonedds_configuration(file.string()) : std::nullopt;
}

spi::PropertyList readable_properties(const pki::ParticipantFolder& files) {
  if (!path_exists(files.properties)) return {};
  return spi::read_property_file(files.properties).value_or(spi::PropertyList());
}

}  // namespace ddssec::cli
