#include "cli/doctor/participant_diagnosis.hpp"

#include <algorithm>
#include <cstdlib>

#include <fmt/format.h>

#include "base/shell_word.hpp"
#include "cli/doctor/folder_configuration.hpp"
#include "cli/doctor/ocsp_checks.hpp"
#include "cli/doctor/own_start.hpp"
#include "cli/doctor/pre_shared_keys.hpp"
#include "cli/doctor/renewal_list_check.hpp"
#include "cli/doctor/weakened_protection.hpp"
#include "cli/inputs/files.hpp"
#include "governance/doctor/cyclonedds_configuration.hpp"
#include "governance/doctor/domain_tag.hpp"
#include "governance/doctor/effective_security.hpp"
#include "governance/doctor/host_plugins.hpp"
#include "pki/certificate_source.hpp"
#include "plugins/access_control/allowed_algorithms.hpp"
#include "plugins/access_control/protection.hpp"
#include "plugins/authentication/credentials.hpp"

namespace ddssec::cli {
namespace {

namespace doctor = governance::doctor;
namespace fs = std::filesystem;
using doctor::LoadedFolder;
using doctor::Outcome;
using governance::Action;

static_assert(pki::kMaxSentPermissionsOctets == authentication::kMaxPermissionsOctets);

constexpr std::string_view kOfHost = "a Cyclone DDS process on ddssec's plugins";

constexpr doctor::Outcomes kCycloneFails{.cyclonedds = Outcome::fail, .ddssec = Outcome::fail};

// True if an application is meant to start with the folder's own configuration. Nodes of ROS 2 are
// secured by their QoS instead.
bool has_own_configuration(const LoadedFolder& folder) {
  return folder.paths.layout != pki::FolderLayout::sros2 &&
         path_exists(configuration_in(folder.paths.folder));
}

std::string export_line(const fs::path& folder) {
  std::error_code ignored;
  const auto file = fs::absolute(configuration_in(folder), ignored).lexically_normal();
  return "export CYCLONEDDS_URI=" + shell_word("file://" + file.string());
}

// Measured with Cyclone DDS 0.10.2: it opens the folder as a file, reads nothing, and goes on.
void report_named_folder(const LoadedFolder& folder, const fs::path& named,
                         doctor::Diagnosis& out) {
  const bool is_meant = has_own_configuration(folder);
  const bool has_file = path_exists(configuration_in(named));
  Finding finding{.rule = Rule::DOC101,
                  .message = fmt::format(
                      "CYCLONEDDS_URI names the folder {}: Cyclone DDS starts, reads nothing "
                      "of it, and runs without security",
                      named.string()),
                  .document = "CYCLONEDDS_URI",
                  .hint = has_file || is_meant ? export_line(has_file ? named : folder.paths.folder)
                                               : "name the file, not its folder"};
  if (is_meant) return out.report(kCycloneFails, std::move(finding));
  finding.severity = Severity::warning;
  out.report({}, std::move(finding));
}

void diagnose_environment(const LoadedFolder& folder, const doctor::Settings& settings,
                          doctor::Diagnosis& out) {
  const char* const uri = std::getenv("CYCLONEDDS_URI");
  if (uri == nullptr || *uri == '\0') return;
  const auto text = doctor::cyclonedds_configuration();
  const auto inline_from = text ? text->size() - doctor::inline_octets(uri) : 0;
  const auto named = doctor::folder_named_by(uri);
  if (text && !named.empty()) {
    const auto security = doctor::effective_security(
        *text, settings.domain, doctor::ConfigurationPlace::variable, inline_from);
    if (security.problems.empty() && !security.applies)
      return report_named_folder(folder, named, out);
  }
  if (text)
    return doctor::diagnose_configuration_in_force(folder, {*text, inline_from}, settings, out);
  out.report(kCycloneFails,
             {.rule = Rule::DOC102,
              .message = fmt::format("CYCLONEDDS_URI is \"{}\" and names a file that cannot be "
                                     "read: Cyclone DDS does not start in this environment",
                                     std::string_view(uri).substr(0, 512)),
              .document = "CYCLONEDDS_URI",
              .hint = "correct the variable; file:// stands before an absolute path"});
}

void diagnose_profiles_file(const LoadedFolder& folder, const doctor::Settings& settings,
                            doctor::Diagnosis& out) {
  const char* const file = std::getenv(doctor::profile_places(settings.lineup.fastdds).variable);
  if (file != nullptr && *file != '\0')
    doctor::diagnose_profile_in_force(folder, file, settings, out);
  doctor::diagnose_profile_of_working_directory(folder, settings, out);
}

// Judges the rule as the plugins do when a participant is created.
Status enforceable(const LoadedFolder& folder, const governance::DomainRule& rule,
                   const access_control::AccessControlOptions& options) {
  DDSSEC_RETURN_IF_ERROR(access_control::check_enforceable(rule, options));
  const auto& allowed = rule.allowed_algorithms;
  if (!allowed || !folder.certificate || !folder.identity_cas || !folder.permissions_cas) return {};
  DDSSEC_RETURN_IF_ERROR(
      access_control::check_identity(*allowed, *folder.certificate, *folder.identity_cas));
  for (const auto& signer : *folder.permissions_cas)
    DDSSEC_RETURN_IF_ERROR(access_control::check_authority(*allowed, signer));
  return {};
}

Finding finding_of(const LoadedFolder& folder, std::string message, int line) {
  return {.rule = Rule::DOC103,
          .message = std::move(message),
          .document = folder.paths.governance.string(),
          .line = line};
}

void diagnose_participant(const LoadedFolder& folder, const governance::DomainRule& rule,
                          bool is_in_use, doctor::Diagnosis& out) {
  const auto number = [](const Error& error) { return static_cast<int>(error.code()); };
  const access_control::AccessControlOptions embedded{
      .host_revises_keys = true, .host_has_pre_shared_keys = true, .host_changes_protection = true};
  if (const auto status = enforceable(folder, rule, embedded); !status) {
    auto finding = finding_of(
        folder, fmt::format("ddssec refuses the governance document: {}", status.error().message()),
        status.error().details().line);
    finding.hint = status.error().hint();
    return out.report({.ddssec = Outcome::fail}, std::move(finding));
  }
  const auto status = enforceable(folder, rule, {});
  if (status) return;
  auto finding = finding_of(folder,
                            fmt::format("{} refuses the participant ({}) for {}: {}; the embedded "
                                        "participant takes the document",
                                        kOfHost, number(status.error()),
                                        status.error().details().field, status.error().message()),
                            status.error().details().line);
  if (is_in_use) return out.report({.ddssec = Outcome::fail}, std::move(finding));
  finding.severity = Severity::warning;
  finding.products = {"ddssec"};
  out.report({}, std::move(finding));
}

void diagnose_topics(const LoadedFolder& folder, const governance::DomainRule& rule, bool is_in_use,
                     doctor::Diagnosis& out) {
  for (const auto& topic : rule.topic_rules) {
    auto finding = refused_by_drop_in(folder, rule, topic, Action::publish);
    if (!finding) finding = refused_by_drop_in(folder, rule, topic, Action::subscribe);
    if (!finding) continue;
    if (is_in_use) {
      out.report({.ddssec = Outcome::late}, std::move(*finding));
      continue;
    }
    finding->severity = Severity::warning;
    finding->products = {"ddssec"};
    out.report({}, std::move(*finding));
  }
}

void diagnose_enforcement(const LoadedFolder& folder, const doctor::Settings& settings,
                          doctor::Diagnosis& out) {
  const auto* const rule =
      folder.governance.model ? folder.governance.model->find(settings.domain) : nullptr;
  if (rule == nullptr) return;
  const bool is_in_use = runs_drop_in(folder);
  if (is_in_use) out.pass(Rule::DOC103);
  diagnose_participant(folder, *rule, is_in_use, out);
  diagnose_topics(folder, *rule, is_in_use, out);
}

}  // namespace

void warn_of_unset_variable(const LoadedFolder& folder, const doctor::Settings& settings,
                            doctor::Diagnosis& out) {
  const char* const uri = std::getenv("CYCLONEDDS_URI");
  if ((uri != nullptr && *uri != '\0') || !has_own_configuration(folder)) return;
  out.report({}, {.rule = Rule::DOC101,
                  .message = fmt::format(
                      "CYCLONEDDS_URI is {} in this shell: a Cyclone DDS application that starts "
                      "here runs WITHOUT security, unless its QoS names the files",
                      uri == nullptr ? "not set" : "empty"),
                  .document = configuration_in(folder.paths.folder),
                  .hint = export_line(folder.paths.folder) +
                          " where the application starts; nothing to do for the embedded "
                          "participant, and where only the folder is to be judged",
                  .products = {doctor::id(doctor::Product::cyclonedds, settings.lineup),
                               doctor::id(doctor::Product::ddssec, settings.lineup)},
                  .severity = Severity::warning});
}

void warn_of_unset_profiles_file(const LoadedFolder& folder, const doctor::Settings& settings,
                                 doctor::Diagnosis& out) {
  const auto* const variable = doctor::profile_places(settings.lineup.fastdds).variable;
  const char* const set = std::getenv(variable);
  const auto file = folder.paths.folder / "fastdds.xml";
  if ((set != nullptr && *set != '\0') || folder.paths.layout == pki::FolderLayout::sros2 ||
      !path_exists(file))
    return;
  std::error_code ignored;
  out.report(
      {}, {.rule = Rule::DOC101,
           .message = fmt::format(
               "{} is {} in this shell: a Fast DDS application that starts here runs WITHOUT "
               "security, unless it names the profile itself",
               variable, set == nullptr ? "not set" : "empty"),
           .document = file,
           .hint = fmt::format("export {}={} where the application starts", variable,
                               shell_word(fs::absolute(file, ignored).lexically_normal().string())),
           .products = {doctor::id(doctor::Product::fastdds, settings.lineup)},
           .severity = Severity::warning});
}

namespace {

void diagnose_tag(const LoadedFolder& folder, doctor::Diagnosis& out) {
  const auto configuration = configuration_for(folder.paths.folder);
  if (!configuration) return;
  const bool is_named = doctor::cyclonedds_configuration().has_value();
  doctor::diagnose_domain_tag(
      *configuration, is_named ? "CYCLONEDDS_URI" : configuration_in(folder.paths.folder), out);
}

}  // namespace

bool runs_drop_in(const LoadedFolder& folder) {
  const auto places = doctor::LoaderPlaces::here();
  const auto configuration = configuration_for(folder.paths.folder);
  auto plugins = configuration ? doctor::host_plugins(*configuration, places)
                               : std::vector<doctor::HostPlugin>();
  if (plugins.empty()) plugins = doctor::plugins_of_node(places);
  return std::ranges::all_of(plugins, [](const doctor::HostPlugin& plugin) {
    return plugin.product == doctor::HostPlugin::PluginProduct::ddssec;
  });
}

// Decides as plugins/cyclonedds/access_control_adapter.cpp does.
std::optional<Finding> refused_by_drop_in(const LoadedFolder& folder,
                                          const governance::DomainRule& domain,
                                          const governance::TopicRule& rule, Action action) {
  if (is_protected(rule.metadata_protection_kind) || is_protected(rule.data_protection_kind))
    return std::nullopt;
  const bool writes = action == Action::publish;
  const bool is_controlled =
      writes ? rule.enable_read_access_control : rule.enable_write_access_control;
  const bool relies_on_messages = !writes && is_protected(domain.rtps_protection_kind);
  const bool has_strangers =
      domain.allow_unauthenticated_participants && (is_controlled || relies_on_messages);
  if (!is_controlled && !has_strangers) return std::nullopt;
  const auto code =
      has_strangers ? Code::unauthenticated_peers_unstoppable : Code::controlled_topic_unguarded;
  const auto element = has_strangers ? "allow_unauthenticated_participants"
                       : writes      ? "enable_read_access_control"
                                     : "enable_write_access_control";
  return finding_of(
      folder,
      fmt::format("{} refuses to make a {} of topics under the topic_rule \"{}\" ({}): <{}> is "
                  "true, and metadata_protection_kind and data_protection_kind are NONE; the "
                  "embedded participant makes it",
                  kOfHost, writes ? "writer" : "reader", rule.topic_expression,
                  static_cast<int>(code), element),
      rule.line);
}

doctor::Diagnosis diagnosis_beyond_folder(const LoadedFolder& folder,
                                          const doctor::Settings& settings) {
  doctor::Diagnosis out(settings.lineup);
  diagnose_pre_shared_keys(folder, settings, out);
  diagnose_ocsp(folder, settings, out);
  diagnose_renewal_list(folder, settings, out);
  diagnose_weakened_protection(folder, out);
  diagnose_own_start(folder, settings, doctor::Diagnosis(out), out);
  diagnose_environment(folder, settings, out);
  diagnose_profiles_file(folder, settings, out);
  diagnose_enforcement(folder, settings, out);
  diagnose_start_in_cyclonedds(folder, settings, runs_drop_in(folder), doctor::Diagnosis(out), out);
  diagnose_tag(folder, out);
  return out;
}

doctor::Diagnosis diagnosis_of(const LoadedFolder& folder, const doctor::Settings& settings) {
  auto out = doctor::diagnose(folder, settings);
  out.append(diagnosis_beyond_folder(folder, settings));
  return out;
}

}  // namespace ddssec::cli
