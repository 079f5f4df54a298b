// The three security plugins of an embedded participant, and the properties that name the documents
// of its folder.
#pragma once

#include <filesystem>
#include <memory>

#include "base/plugin_services.hpp"
#include "base/result.hpp"
#include "rtps/security/security_options.hpp"

namespace ddssec::secured {

/// Owns the three builtin plugins of DDS-Security. It must outlive the participants that use them.
class SecurityPluginSet {
 public:
  /// The clock, random source and event sink in `services` must outlive this object.
  /// If the environment variable DDSSEC_STATUS_DIR names a folder, a socket there shows the
  /// documents in use (docs/configuration.md).
  explicit SecurityPluginSet(const PluginServices& services);
  ~SecurityPluginSet();

  /// Sets the grace period of org.ddssec.clock_step_grace: how long a changed system clock is not
  /// believed. Without a call, SteadyCalendar::kDefaultGrace applies. Error: invalid_property.
  Status set_clock_step_grace(const spi::PropertyList& properties);

  /// Returns the plugins for the options of a participant (DomainParticipantOptions::security).
  /// They live as long as this object.
  rtps::SecurityPlugins plugins();

  /// Returns the options of a participant with the documents of this folder, and takes the clock
  /// step grace of its properties. Errors: those of folder_properties and set_clock_step_grace.
  Result<rtps::SecurityOptions> security_options(const std::filesystem::path& folder);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// Returns the properties that name the documents of a participant's folder, in the layout of
/// `ddssec init` or of a ROS 2 keystore.
/// - crl.pem, the list of revoked certificates, is optional. It also takes effect if it is created
///   later.
/// - security.properties, a file of further properties (plugins/spi/property_file.hpp), is
/// optional. The contents of the documents are checked only when a participant is created. Errors:
/// those of a folder that is no participant's (file_not_found, file_unreadable), those of
/// pki::uri_of, those of spi::read_property_file, property_without_effect (security.properties sets
/// a property that a file of the folder already sets).
Result<spi::PropertyList> folder_properties(const std::filesystem::path& folder);

}  // namespace ddssec::secured
