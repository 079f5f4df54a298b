#include "secured/security_plugin_set.hpp"

#include <algorithm>

#include "base/status_service.hpp"
#include "pki/certificate_source.hpp"
#include "pki/participant_folder.hpp"
#include "plugins/authentication/authentication.hpp"
#include "plugins/cryptography/cryptography.hpp"
#include "plugins/spi/clock_step_grace.hpp"
#include "plugins/spi/property_file.hpp"
#include "plugins/spi/property_names.hpp"
#include "secured/participant_check.hpp"
#include "secured/reported_calendar.hpp"
#include "secured/start_check.hpp"

namespace ddssec::secured {

struct SecurityPluginSet::Parts {
  explicit Parts(const PluginServices& services)
      : documents(shared_status_record(&services.events)),
        calendar(services.clock, services.events),
        authentication(authentication::make_authentication(judging(services))),
        access_control(access_control::make_access_control(judging(services),
                                                           embedded_access_control_options())),
        cryptography(cryptography::make_cryptography(services)) {}

  // Returns the services for the plugins that judge documents.
  PluginServices judging(const PluginServices& services) const {
    PluginServices out{calendar, services.random, services.events};
    out.documents = documents.get();
    return out;
  }

  std::shared_ptr<DocumentsInUse> documents;  // nullptr if no documents are shown
  ReportedCalendar calendar;
  std::unique_ptr<spi::Authentication> authentication;
  std::unique_ptr<spi::AccessControl> access_control;
  std::unique_ptr<spi::Cryptography> cryptography;
};

SecurityPluginSet::SecurityPluginSet(const PluginServices& services)
    : parts_(std::make_unique<Parts>(services)) {}
SecurityPluginSet::~SecurityPluginSet() = default;

rtps::SecurityPlugins SecurityPluginSet::plugins() {
  return {*parts_->authentication, *parts_->access_control, *parts_->cryptography};
}

Status SecurityPluginSet::set_clock_step_grace(const spi::PropertyList& properties) {
  DDSSEC_ASSIGN_OR_RETURN(const auto grace, spi::clock_step_grace(properties));
  parts_->calendar.set_grace(grace);
  return {};
}

Result<rtps::SecurityOptions> SecurityPluginSet::security_options(
    const std::filesystem::path& folder) {
  DDSSEC_ASSIGN_OR_RETURN(auto properties, folder_properties(folder));
  DDSSEC_RETURN_IF_ERROR(set_clock_step_grace(properties));
  return rtps::SecurityOptions{plugins(), std::move(properties)};
}

Result<spi::PropertyList> folder_properties(const std::filesystem::path& path) {
  namespace property = spi::property;
  DDSSEC_RETURN_IF_ERROR(explain_unless_participant(path));
  const auto folder = pki::participant_folder(path);
  spi::PropertyList out;
  const auto add = [&](std::string_view name, const std::filesystem::path& file) {
    out.push_back({std::string(name), "file:" + file.string(), false});
  };
  const auto add_item = [&](std::string_view name, const std::filesystem::path& file) -> Status {
    DDSSEC_ASSIGN_OR_RETURN(auto uri, pki::uri_of(file));
    out.push_back({std::string(name), std::move(uri), false});
    return {};
  };
  DDSSEC_RETURN_IF_ERROR(add_item(property::kIdentityCa, folder.identity_ca));
  DDSSEC_RETURN_IF_ERROR(add_item(property::kIdentityCertificate, folder.certificate));
  DDSSEC_RETURN_IF_ERROR(add_item(property::kPrivateKey, folder.key));
  DDSSEC_RETURN_IF_ERROR(add_item(property::kPermissionsCa, folder.permissions_ca));
  add(property::kGovernance, folder.governance);
  add(property::kPermissions, folder.permissions);
  // A dangling symbolic link counts as present: a file was meant to be there.
  add(pki::may_exist(folder.crl) ? property::kCrl : property::kLaterCrl, folder.crl);
  if (!pki::may_exist(folder.properties)) return out;
  DDSSEC_ASSIGN_OR_RETURN(auto file_properties, spi::read_property_file(folder.properties));
  const auto without_effect = [&](const std::string& name, std::string why) {
    return fail(Code::property_without_effect,
                {.document = folder.properties.string(), .field = name, .note = std::move(why)});
  };
  for (auto& further : file_properties) {
    if (spi::find_property(out, further.name) != nullptr)
      return without_effect(further.name, "a file in the folder takes precedence");
    out.push_back(std::move(further));
  }
  return out;
}

}  // namespace ddssec::secured
