#include "cli/doctor/own_start.hpp"

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "cli/doctor/folder_configuration.hpp"
#include "cli/inputs/files.hpp"
#include "governance/doctor/cyclonedds_configuration.hpp"
#include "governance/doctor/effective_security.hpp"
#include "governance/doctor/expanded_variables.hpp"
#include "pki/certificate_source.hpp"
#include "pki/login_ban.hpp"
#include "pki/participant_folder.hpp"
#include "plugins/spi/clock_step_grace.hpp"
#include "plugins/spi/process_properties.hpp"
#include "plugins/spi/property_names.hpp"
#include "secured/security_plugin_set.hpp"
#include "secured/start_check.hpp"

namespace ddssec::cli {
namespace {

namespace doctor = governance::doctor;
namespace fs = std::filesystem;
namespace property = spi::property;
using doctor::Outcome;

Status start(spi::PropertyList properties, const access_control::AccessControlOptions& options,
             const doctor::Settings& settings) {
  return secured::check_start(std::move(properties), options, settings.domain, settings.now);
}

Status start_embedded(const fs::path& folder, const doctor::Settings& settings) {
  DDSSEC_ASSIGN_OR_RETURN(auto properties, secured::folder_properties(folder));
  DDSSEC_RETURN_IF_ERROR(spi::clock_step_grace(properties));
  return start(std::move(properties), secured::embedded_access_control_options(), settings);
}

bool starts(const doctor::Diagnosis& diagnosis) {
  return diagnosis.outcomes().of(doctor::Product::ddssec) < Outcome::late;
}

// An error about a value names the property, and an error about a file names the file.
std::string document_of(const Error& error, const fs::path& otherwise) {
  const auto& document = error.details().document;
  return document.empty() || !path_exists(document) ? otherwise.string() : document;
}

}  // namespace

void diagnose_own_start(const doctor::LoadedFolder& folder, const doctor::Settings& settings,
                        const doctor::Diagnosis& before, doctor::Diagnosis& out) {
  const pki::LoginBan no_logins(pki::may_be_changed_by_others(folder.paths));
  std::error_code ignored;
  if (!fs::exists(folder.paths.properties, ignored)) return;
  if (!starts(before) || !starts(doctor::diagnose(folder, settings))) return;
  out.pass(Rule::DOC093);
  const auto started = start_embedded(folder.paths.folder, settings);
  if (started) return;
  out.report({.ddssec = Outcome::fail},
             {.rule = Rule::DOC093,
              .message = started.error().to_sentence(),
              .document = document_of(started.error(), folder.paths.properties),
              .line = started.error().details().line});
}

// ---- Cyclone DDS

namespace {

// An element of Cyclone DDS's configuration, and the property as which its core passes the value.
struct ConfiguredProperty {
  std::string_view element;
  std::string_view name;
  fs::path pki::ParticipantFolder::*file;  // the folder's own file; nullptr: there is none
};
using Files = pki::ParticipantFolder;
constexpr ConfiguredProperty kConfigured[] = {
    {"identityca", property::kIdentityCa, &Files::identity_ca},
    {"identitycertificate", property::kIdentityCertificate, &Files::certificate},
    {"privatekey", property::kPrivateKey, &Files::key},
    {"password", property::kPassword, nullptr},
    {"trustedcadirectory", property::kTrustedCaDir, nullptr},
    {"crl", property::kCrl, nullptr},
    {"permissionsca", property::kPermissionsCa, &Files::permissions_ca},
    {"governance", property::kGovernance, &Files::governance},
    {"permissions", property::kPermissions, &Files::permissions},
};

// A configuration, and its name in messages.
struct HostConfiguration {
  std::string document;
  doctor::EffectiveSecurity security;
};

// The properties of a participant that its QoS secures with the folder's files, as ROS 2 does.
Result<spi::PropertyList> properties_of_folder(const pki::ParticipantFolder& files) {
  spi::PropertyList out;
  for (const auto& [element, name, file] : kConfigured) {
    if (file == nullptr) continue;
    DDSSEC_ASSIGN_OR_RETURN(auto uri, pki::uri_of(files.*file));
    out.push_back({std::string(name), std::move(uri), false});
  }
  return out;
}

spi::PropertyList properties_of(const doctor::EffectiveSecurity& security, DomainId domain) {
  spi::PropertyList out;
  for (const auto* plugin : {&security.authentication, &security.access_control})
    for (const auto& [element, name, file] : kConfigured)
      if (const auto* value = *plugin ? (*plugin)->value(element) : nullptr)
        out.push_back({std::string(name),
                       doctor::expanded_variables(value->text, domain).value_or(value->text),
                       false});
  return out;
}

// The configuration that the environment names, or else the folder's own. Empty for an application
// without a configuration.
std::optional<HostConfiguration> host_configuration_for(const doctor::LoadedFolder& folder,
                                                        const doctor::Settings& settings) {
  using Place = doctor::ConfigurationPlace;
  if (const auto text = doctor::cyclonedds_configuration()) {
    const auto inline_from = text->size() - doctor::inline_octets(std::getenv("CYCLONEDDS_URI"));
    return HostConfiguration{
        "CYCLONEDDS_URI",
        doctor::effective_security(*text, settings.domain, Place::variable, inline_from)};
  }
  const auto file = configuration_in(folder.paths.folder);
  const auto text = path_exists(file) && folder.paths.layout != pki::FolderLayout::sros2
                        ? doctor::cyclonedds_configuration(file.string())
                        : std::nullopt;
  if (!text) return std::nullopt;
  return HostConfiguration{file.string(),
                           doctor::effective_security(*text, settings.domain, Place::file)};
}

// False if the environment is that of another participant.
bool is_of(const pki::ParticipantFolder& files, const spi::PropertyList& properties) {
  const auto named = pki::load_uri(spi::property_value(properties, property::kIdentityCertificate),
                                   "", pki::kMaxCertificateOctets);
  const auto own = pki::uri_of(files.certificate);
  if (!named || !own) return false;
  const auto octets = pki::load_uri(*own, "", pki::kMaxCertificateOctets);
  return octets && *octets == *named;
}

std::string variable(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? std::string() : value;
}

Status start_in_cyclonedds(spi::PropertyList of_host, const doctor::Settings& settings) {
  DDSSEC_ASSIGN_OR_RETURN(auto properties, spi::with_process_properties(std::move(of_host)));
  DDSSEC_RETURN_IF_ERROR(spi::check_properties_of_adapters(properties));
  // Cyclone DDS does not read this property; only an embedded participant does.
  std::erase_if(properties,
                [](const auto& one) { return one.name == property::kGovernanceChangeTime; });
  return start(std::move(properties), {}, settings);
}

}  // namespace

void diagnose_start_in_cyclonedds(const doctor::LoadedFolder& folder,
                                  const doctor::Settings& settings, bool is_in_use,
                                  const doctor::Diagnosis& before, doctor::Diagnosis& out) {
  const pki::LoginBan no_logins(pki::may_be_changed_by_others(folder.paths));
  const auto file = variable(spi::kPropertiesVariable);
  const auto configuration = host_configuration_for(folder, settings);
  const bool is_configured = configuration && configuration->security.applies;
  if (!is_configured && file.empty() && variable(spi::kCipherVariable).empty()) return;
  if (!starts(before) || !starts(doctor::diagnose(folder, settings))) return;
  auto of_folder = properties_of_folder(folder.paths);
  if (of_folder && folder.password && is_configured) {
    const auto of_file = properties_of(configuration->security, settings.domain);
    of_folder->push_back({std::string(property::kPassword),
                          std::string(spi::property_value(of_file, property::kPassword)), false});
  }
  // If the folder's files alone do not start, another check reports the document that prevents it.
  if (!of_folder || !start(*of_folder, {}, settings)) return;
  const auto of_host =
      is_configured ? properties_of(configuration->security, settings.domain) : *of_folder;
  if (!is_of(folder.paths, of_host)) return;
  const auto started = start_in_cyclonedds(of_host, settings);
  if (started) return;
  const auto& details = started.error().details();
  const bool is_of_host = spi::find_property(of_host, details.document) != nullptr;
  const auto otherwise =
      file.empty() || is_of_host
          ? fs::path(is_configured ? configuration->document : spi::kCipherVariable)
          : fs::path(file);
  Finding finding{.rule = Rule::DOC093,
                  .message = fmt::format("a Cyclone DDS process on ddssec's plugins does not start "
                                         "with the properties that are set: {}",
                                         started.error().to_sentence()),
                  .document = document_of(started.error(), otherwise),
                  .line = details.line};
  if (is_in_use) return out.report({.ddssec = Outcome::fail}, std::move(finding));
  finding.severity = Severity::warning;
  finding.products = {"ddssec"};
  out.report({}, std::move(finding));
}

}  // namespace ddssec::cli
