// What secures an embedded participant: the three engines, and the documents of a folder.
#pragma once

#include <filesystem>

#include "plugins/access_control/access_control.hpp"
#include "plugins/authentication/authentication.hpp"
#include "plugins/cryptography/cryptography.hpp"
#include "rtps/security/own_security.hpp"

namespace ddssec::secured {

/// The builtin plugins of DDS-Security; they outlive the participants that use them.
class Engines {
 public:
  /// The environment's parts outlive the engines.
  explicit Engines(const Environment& environment)
      : authentication_(authentication::make_authentication(environment)),
        access_control_(access_control::make_access_control(
            environment, {.host_revises_keys = true, .host_has_pre_shared_keys = true})),
        cryptography_(cryptography::make_cryptography(environment)) {}

  rtps::SecurityPlugins view() { return {*authentication_, *access_control_, *cryptography_}; }

 private:
  std::unique_ptr<spi::Authentication> authentication_;
  std::unique_ptr<spi::AccessControl> access_control_;
  std::unique_ptr<spi::Cryptography> cryptography_;
};

/// Names the documents of a participant's folder, as `ddssec init` or a ROS 2 keystore has it; a
/// list of revoked certificates (crl.pem) counts if it is there, and when it comes later; a file of
/// further properties (security.properties, spi/property_file.hpp) if it is there. Errors:
/// file_not_found, file_unreadable (no participant's folder), those of spi::read_property_file,
/// property_without_effect (a further property that a file of the folder sets). What is in the
/// documents is judged when a participant is made.
Result<spi::PropertyList> folder_properties(const std::filesystem::path& folder);

}  // namespace ddssec::secured
