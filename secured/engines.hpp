// The three security plugins of an embedded participant, and the properties that name the documents
// of its folder.
#pragma once

#include <filesystem>

#include "base/status_service.hpp"
#include "plugins/access_control/access_control.hpp"
#include "plugins/authentication/authentication.hpp"
#include "plugins/cryptography/cryptography.hpp"
#include "rtps/security/own_security.hpp"
#include "secured/reported_calendar.hpp"

namespace ddssec::secured {

/// Owns the three builtin plugins of DDS-Security. It must outlive the participants that use them.
class Engines {
 public:
  /// The clock, random source and event sink in `environment` must outlive this object.
  /// If the environment variable DDSSEC_STATUS_DIR names a folder, a socket there shows the
  /// documents in use (base/status_service.hpp).
  explicit Engines(const Environment& environment)
      : documents_(documents_shown(&environment.events)),
        calendar_(environment.clock, environment.events),
        authentication_(authentication::make_authentication(judging(environment))),
        access_control_(access_control::make_access_control(judging(environment),
                                                            {.host_revises_keys = true,
                                                             .host_has_pre_shared_keys = true,
                                                             .host_changes_protection = true})),
        cryptography_(cryptography::make_cryptography(environment)) {}

  /// Takes the property org.ddssec.clock_step_grace: how long a system clock that was set is not
  /// believed. Without a call: SteadyCalendar::kDefaultGrace. Error: invalid_property.
  Status set_clock_step_grace(const spi::PropertyList& properties);

  rtps::SecurityPlugins view() { return {*authentication_, *access_control_, *cryptography_}; }

 private:
  /// For the plugins that judge documents.
  Environment judging(const Environment& environment) const {
    Environment out{calendar_, environment.random, environment.events};
    out.documents = documents_.get();
    return out;
  }

  std::shared_ptr<DocumentsInUse> documents_;  ///< null: none are shown
  ReportedCalendar calendar_;
  std::unique_ptr<spi::Authentication> authentication_;
  std::unique_ptr<spi::AccessControl> access_control_;
  std::unique_ptr<spi::Cryptography> cryptography_;
};

/// Returns the properties that name the documents of a participant's folder, in the layout of
/// `ddssec init` or of a ROS 2 keystore.
/// - crl.pem, the list of revoked certificates, is optional. It also takes effect if it is created
///   later.
/// - security.properties, a file of further properties (spi/property_file.hpp), is optional.
/// The contents of the documents are checked only when a participant is created.
/// Errors: file_not_found, file_unreadable (not a participant's folder), those of
/// spi::read_property_file, property_without_effect (security.properties sets a property that a
/// file of the folder already sets).
Result<spi::PropertyList> folder_properties(const std::filesystem::path& folder);

}  // namespace ddssec::secured
